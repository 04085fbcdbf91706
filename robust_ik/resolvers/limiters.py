"""How one level's motion is fitted into the bounds, without touching higher levels.

A limiter gets the motion that the level's inverse wants. It may change only what the level leaves free, or give the
level less; it never uses what higher levels need.
"""

from __future__ import annotations

import abc
from dataclasses import dataclass

import numpy as np

from robust_ik.bounds import ROUNDING, Bounds
from robust_ik.checks import Array
from robust_ik.linalg import least_norm_solution
from robust_ik.resolvers.freedom import Freedom, Reduced


@dataclass(frozen=True, eq=False)
class Wish:
    """One level's wish and where it stands.

    Attributes:
        qdot: What higher levels have settled, inside the bounds, (n,).
        motion: What the level's inverse wants on top, (n,), within `freedom`.
        reduced: The level's Jacobian in `freedom`.
        freedom: What higher levels leave.
        bounds: What must be respected.
    """

    qdot: Array
    motion: Array
    reduced: Reduced
    freedom: Freedom
    bounds: Bounds


class Limiter(abc.ABC):
    """A way to fit a level's motion into the bounds."""

    @abc.abstractmethod
    def limit(self, wish: Wish) -> tuple[Array, float]:
        """The motion that the level gets, (n,), and the share of its wish that this is, in [0, 1]."""


@dataclass(frozen=True)
class Scaling(Limiter):
    """The whole motion slower, as much as the tightest bound asks. Keeps the direction; uses no redundancy."""

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        scale = wish.bounds.largest_step(wish.qdot, wish.motion)
        return scale * wish.motion, scale


@dataclass(frozen=True)
class Saturation(Limiter):
    """Saturation in the null space: joints at their bounds stay there, and the level's other joints take over.

    The direction is kept; where joints run out, the level is slowed. At most as many passes as there are joints, each a
    small QR factorisation: fit for hard real time.

    Source: Flacco, De Luca, Khatib 2015 (SNS), with rows of any kind as bounds and the level's filtered motion as task.
    """

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        best, most = Scaling().limit(wish)
        if most == 1:
            return best, most
        basis, bounds = wish.freedom.basis, wish.bounds
        every = np.concatenate([np.eye(len(wish.qdot)), bounds.rows])
        start = every @ wish.qdot
        low = np.concatenate([bounds.lower, bounds.floor]) - start
        high = np.concatenate([bounds.upper, np.full(len(bounds.floor), np.inf)]) - start
        task, moved = wish.reduced.motions @ basis, every @ basis
        wanted = wish.reduced.motions @ wish.motion
        held: list[int] = []
        values: list[float] = []
        while most < 1 and len(held) + len(task) <= basis.shape[1]:
            solution = _held(task, wanted, moved[held], np.array(values))
            if solution is None:
                break
            offset, slope = (moved @ part for part in solution)
            free = np.setdiff1d(np.arange(len(every)), held)
            least, share, row, value = _span(offset, slope, low, high, free)
            if least <= share and share > most:
                most, best = share, basis @ (solution[0] + share * solution[1])
            if row < 0:
                break
            held.append(row)
            values.append(value)
        return best, most


def _held(task: Array, wanted: Array, rows: Array, values: Array) -> tuple[Array, Array] | None:
    """Offset and slope of the smallest motion with task = s·wanted and the held rows at their values."""
    lengths = np.linalg.norm(rows, axis=1)
    if (lengths < 1e-9).any():
        return None
    right = np.zeros((len(task) + len(rows), 2))
    right[len(task) :, 0], right[: len(task), 1] = values / lengths, wanted
    solution = least_norm_solution(np.concatenate([task, rows / lengths[:, None]]), right)
    return None if solution is None else (solution[:, 0], solution[:, 1])


def _span(offset: Array, slope: Array, low: Array, high: Array, free: Array) -> tuple[float, float, int, float]:
    """The s in [0, 1] for which low ≤ offset + s·slope ≤ high on the free rows.

    Returns:
        Least and greatest s (none if the one exceeds the other), the row that stops it, −1 if none, and its bound.
    """
    offset, slope, low, high = offset[free], slope[free], low[free] - ROUNDING, high[free] + ROUNDING
    with np.errstate(divide="ignore", invalid="ignore"):
        to_low, to_high = (low - offset) / slope, (high - offset) / slope
    still, rising = slope == 0, slope > 0
    out = (offset < low) | (offset > high)
    enter = np.where(still, np.where(out, np.inf, -np.inf), np.where(rising, to_low, to_high))
    leave = np.where(still, np.where(out, -np.inf, np.inf), np.where(rising, to_high, to_low))
    least, greatest = max(0.0, float(enter.max(initial=0.0))), min(1.0, float(leave.min(initial=1.0)))
    excess = np.maximum(offset + slope - high, low - offset - slope)
    if excess.max(initial=-np.inf) <= 0:
        return least, greatest, -1, 0.0
    first = excess > 0
    first &= leave <= leave[first].min() + 1e-9  # joints at their bounds all stop it at once: the one furthest out
    worst = int(np.argmax(np.where(first, excess, -np.inf)))
    bound = high[worst] - ROUNDING if offset[worst] + slope[worst] > high[worst] else low[worst] + ROUNDING
    return least, greatest, int(free[worst]), float(bound)
