"""Solves a small quadratic program to the last digit, from a point inside: the primal active-set method.

Every iterate is inside the constraints and no worse than the one before: it cannot fail, only stop early.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.kinematics.svd import complement, length

SAME = 1e-10
"""Unit rows with a smaller slope than this along a unit step do not stop it."""

ROUNDING = 1e-11
"""Multipliers below this fraction of the gradient count as zero."""

SHORT = 1e-12
"""Rows shorter than this fraction of the longest are rounding: a joint that does not take part stops nothing."""


def minimise(
    hessian: Array, slope: Array, rows: Array, room: Array, start: Array, working: Sequence[int] = ()
) -> Array:
    """The y that minimises ½ yᵀ H y + gᵀ y with rows y ≤ room.

    Args:
        hessian: H, (d, d), positive definite.
        slope: g, (d,).
        rows: (r, d).
        room: (r,).
        start: A point inside the constraints, (d,).
        working: Independent rows on whose bounds `start` lies: a guess of the rows that act at the minimum.

    Source: Nocedal, Wright 2006, algorithm 16.3, with null spaces by QR.
    """
    return minimum(hessian, slope, rows, room, start, working)[0]


def minimum(
    hessian: Array, slope: Array, rows: Array, room: Array, start: Array, working: Sequence[int] = ()
) -> tuple[Array, list[int]]:
    """As `minimise`, with the rows that act at the minimum: a guess for the next similar program."""
    lengths = np.linalg.norm(rows, axis=1)
    kept = lengths > SHORT * lengths.max(initial=0.0)
    index, rows_kept = np.cumsum(kept) - 1, np.flatnonzero(kept)
    rows, room = rows[kept] / lengths[kept, None], room[kept] / lengths[kept]
    y, held = start, [int(index[each]) for each in working if kept[each]]
    for _ in range(3 * (len(rows) + len(y))):
        step = _free_step(hessian, hessian @ y + slope, rows[held])
        share, stop = _first_stop(rows, room - rows @ y, step, held)
        y = y + share * step
        if stop is not None:
            held.append(stop)
            continue
        gradient = hessian @ y + slope
        pull = _multipliers(rows[held], gradient)
        if pull.min(initial=0.0) >= -ROUNDING * np.abs(gradient).max():
            break
        del held[int(np.argmin(pull))]
    return y, [int(rows_kept[each]) for each in held]


def _free_step(hessian: Array, gradient: Array, held: Array) -> Array:
    """The step to the minimum within the null space of the held rows."""
    if not len(held):
        return np.asarray(np.linalg.solve(hessian, -gradient))
    free = complement(np.linalg.qr(held.T)[0].T)
    return np.asarray(free @ np.linalg.solve(free.T @ hessian @ free, -free.T @ gradient))


def _first_stop(rows: Array, room: Array, step: Array, held: Sequence[int]) -> tuple[float, int | None]:
    """The feasible part of a step, in [0, 1], and the row that stops it."""
    slopes = rows @ step
    slopes[held] = 0.0
    meets = slopes > np.maximum(room, SAME * length(step))
    if not meets.any():
        return 1.0, None
    shares: NDArray[np.float64] = np.full(len(rows), np.inf)
    shares[meets] = np.maximum(room[meets], 0.0) / slopes[meets]
    stop = int(np.argmin(shares))
    return float(shares[stop]), stop


def _multipliers(held: Array, gradient: Array) -> Array:
    """The multipliers of the held rows; negative for a row from which the gradient points away."""
    if not len(held):
        return np.zeros(0)
    Q, R = np.linalg.qr(held.T)
    return np.asarray(np.linalg.solve(R, -(Q.T @ gradient)))
