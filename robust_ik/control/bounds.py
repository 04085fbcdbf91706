"""Bounds on q̇: a box, and rows whose product with q̇ must not fall below a floor. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array, readonly

CONTRADICTION = 1e-9
"""Bounds that cross by less than this count as equal, for rounding."""

ACTIVE = 1e-9
"""A bound is active if q̇ is this close to it."""

ROUNDING = 1e-12
"""A motion may go past a bound by this much; otherwise rounding could stop it."""


@dataclass(frozen=True, eq=False)
class Bounds:
    """lower ≤ q̇ ≤ upper, and rows q̇ ≥ floor.

    Attributes:
        lower: (n,), rad/s or m/s, −∞ for none.
        upper: (n,), not below `lower`.
        lower_cause: The limit behind each entry of `lower`, (n,) of str: "joint1 position".
        upper_cause: The same for `upper`.
        rows: (r, n).
        floor: (r,), the least value of rows @ q̇.
        row_cause: The limit behind each row, r strings.
        contradictions: Limits that yielded because they contradict stronger ones.
        unhurried: The box without acceleration limits, lower and upper, (n,) each; None if there are no such limits.
        last: The velocities of the last step, (n,), if acceleration is limited.
        fastest: Pure speed limits, (n,), without the box's bounds that protect position limits; None if there are none.
    """

    lower: Array
    upper: Array
    lower_cause: NDArray[np.str_]
    upper_cause: NDArray[np.str_]
    rows: Array = field(default_factory=lambda: np.zeros((0, 0)))
    floor: Array = field(default_factory=lambda: np.zeros(0))
    row_cause: tuple[str, ...] = ()
    contradictions: tuple[str, ...] = ()
    unhurried: tuple[Array, Array] | None = None
    last: Array | None = None
    fastest: Array | None = None

    def __post_init__(self) -> None:
        if not len(self.rows):
            object.__setattr__(self, "rows", np.zeros((0, len(self.lower))))

    @classmethod
    def free(cls, n: int) -> Bounds:
        """No bounds."""
        return cls(*_no_box(n))

    @classmethod
    def of_rows(cls, rows: Array, floor: Array, cause: tuple[str, ...]) -> Bounds:
        """Rows only: rows (r, n), floor (r,), and the limit behind each row."""
        return cls(*_no_box(rows.shape[1]), rows, floor, cause)

    def within(self, stronger: Bounds) -> Bounds:
        """Both bounds together; if the boxes contradict each other, `stronger` wins and the contradiction is noted."""
        lower = np.clip(self.lower, stronger.lower, stronger.upper)
        upper = np.clip(self.upper, stronger.lower, stronger.upper)
        crossed = (self.lower > stronger.upper + CONTRADICTION) | (self.upper < stronger.lower - CONTRADICTION)
        yields = np.where(self.lower > stronger.upper, self.lower_cause, self.upper_cause)
        return Bounds(
            lower=lower,
            upper=upper,
            lower_cause=np.select(
                [self.lower > stronger.upper, lower > stronger.lower],
                [stronger.upper_cause, self.lower_cause],
                stronger.lower_cause,
            ),
            upper_cause=np.select(
                [self.upper < stronger.lower, upper < stronger.upper],
                [stronger.lower_cause, self.upper_cause],
                stronger.upper_cause,
            ),
            rows=np.concatenate([stronger.rows, self.rows]),
            floor=np.concatenate([stronger.floor, self.floor]),
            row_cause=stronger.row_cause + self.row_cause,
            contradictions=stronger.contradictions + self.contradictions + tuple(yields[crossed]),
            unhurried=self._unhurried_within(stronger),
            last=self.last if stronger.last is None else stronger.last,
            fastest=least_of(self.fastest, stronger.fastest),
        )

    def _unhurried_within(self, stronger: Bounds) -> tuple[Array, Array] | None:
        if self.unhurried is None and stronger.unhurried is None:
            return None
        lower, upper = self.unhurried or (self.lower, self.upper)
        low, high = stronger.unhurried or (stronger.lower, stronger.upper)
        return np.clip(lower, low, high), np.clip(upper, low, high)

    @property
    def lasting(self) -> Bounds:
        """The same bounds without acceleration limits."""
        if self.unhurried is None:
            return self
        lower, upper = self.unhurried
        return replace(self, lower=lower, upper=upper, unhurried=None, last=None)

    def largest_step(self, qdot: Array, change: Array) -> float:
        """The largest s in [0, 1] for which q̇ + s·change stays inside; q̇ is inside."""
        room = np.concatenate([self.upper - qdot, qdot - self.lower, self.rows @ qdot - self.floor])
        used = np.concatenate([change, -change, -(self.rows @ change)])
        room = np.maximum(room, 0.0) + ROUNDING
        limiting = used > room
        return float(np.min(room[limiting] / used[limiting], initial=1.0))

    def contains(self, qdot: Array, tolerance: float = ACTIVE) -> bool:
        """Whether q̇ is within the bounds."""
        return bool(
            (qdot >= self.lower - tolerance).all()
            and (qdot <= self.upper + tolerance).all()
            and (self.rows @ qdot >= self.floor - tolerance).all()
        )

    def active(self, qdot: Array) -> tuple[str, ...]:
        """The limits whose bounds q̇ lies on."""
        at_lower = qdot <= self.lower + ACTIVE
        at_upper = (qdot >= self.upper - ACTIVE) & ~at_lower
        on_floor = self.rows @ qdot <= self.floor + ACTIVE
        return (
            *(str(cause) for cause in self.lower_cause[at_lower]),
            *(str(cause) for cause in self.upper_cause[at_upper]),
            *(cause for cause, there in zip(self.row_cause, on_floor) if there),
        )


@cache
def _no_box(n: int) -> tuple[Array, Array, NDArray[np.str_], NDArray[np.str_]]:
    """A box without bounds, read-only since it is shared: lower, upper, and what is behind them, (n,) each."""
    nothing = np.full(n, "")
    nothing.setflags(write=False)
    return readonly(np.full(n, -np.inf)), readonly(np.full(n, np.inf)), nothing, nothing


def least_of(a: Array | None, b: Array | None) -> Array | None:
    """The smaller one, entry by entry; None stands for no bound."""
    if a is None or b is None:
        return b if a is None else a
    return np.minimum(a, b)
