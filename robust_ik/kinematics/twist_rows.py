"""The six rows of a twist, by name."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Sequence

from robust_ik.checks import Array
from robust_ik.errors import InputError

ROWS = ("x", "y", "z", "wx", "wy", "wz")
DEFICIENT = 1e-3
"""Of the largest singular value: a file that rounds π/2 leaves ratios of 1e-5 where there should be none."""


def checked_rows(rows: Sequence[str]) -> tuple[str, ...]:
    """Some of the six rows, each at most once.

    Raises:
        InputError: They are not; the message says what was given.
    """
    names = tuple(rows) if isinstance(rows, (list, tuple)) else ()
    if not names or any(name not in ROWS for name in names) or len(set(names)) < len(names):
        raise InputError(f"rows must be some of {' '.join(ROWS)}, each at most once, got {reprlib.repr(rows)}")
    return names


def movable_rows(rows: Sequence[str], deficient: Callable[[tuple[str, ...]], bool]) -> tuple[str, ...]:
    """The rows if an arm's Jacobian has full rank in them somewhere, else those of the tip's position that it can move.

    An arm with fewer joints than task rows is singular everywhere in them; what it can do is move its tip. Rotations
    are added only where a single position row is left.

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


def always_deficient(s: Array, rows: int, joints: int) -> bool:
    """Whether no Jacobian of many samples has full rank, by their singular values (N, k)."""
    return rows > joints or bool((s[:, -1] <= DEFICIENT * s[:, 0]).all())
