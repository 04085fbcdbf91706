"""The six rows of a twist, by name."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Sequence

from robust_ik.checks import Array
from robust_ik.errors import InputError

ROWS = ("x", "y", "z", "wx", "wy", "wz")
DEFICIENT = 1e-3
"""Singular values of at most this fraction of the largest count as 0: a file that rounds π/2 leaves ratios of 1e-5."""


def checked_rows(rows: Sequence[str]) -> tuple[str, ...]:
    """The rows as a tuple, if each is one of the six and given once.

    Raises:
        InputError: They are not; the message says what was given.
    """
    names = tuple(rows) if isinstance(rows, (list, tuple)) else ()
    if not names or any(name not in ROWS for name in names) or len(set(names)) < len(names):
        raise InputError(f"rows must be some of {' '.join(ROWS)}, each at most once, got {reprlib.repr(rows)}")
    return names


def movable_rows(rows: Sequence[str], deficient: Callable[[tuple[str, ...]], bool]) -> tuple[str, ...]:
    """The rows, if an arm's Jacobian has full rank in them somewhere, else the position rows in which its tip can move.

    An arm with fewer joints than task rows is singular everywhere in them; it can still move its tip. Rotations are
    added only if a single position row is left.

    Args:
        rows: Task rows.
        deficient: Whether the Jacobian lacks rank in some rows at every configuration.
    """
    if not deficient(tuple(rows)):
        return tuple(rows)
    chosen: tuple[str, ...] = ()
    for row in sorted(rows, key=ROWS.index):
        done = len(chosen) > 1 and row.startswith("w")
        if not done and not deficient((*chosen, row)):
            chosen = (*chosen, row)
    return chosen or tuple(rows[:1])


def always_deficient(s: Array, rows: int, joints: int, largest: Array | None = None) -> bool:
    """Whether none of many sample Jacobians has full rank, from their singular values (N, k).

    Args:
        s: Their singular values in some rows.
        rows: The number of these rows.
        joints: The number of joints.
        largest: The largest singular value in all rows that count, (N,); by default in these.
    """
    return rows > joints or bool((s[:, -1] <= DEFICIENT * (s[:, 0] if largest is None else largest)).all())
