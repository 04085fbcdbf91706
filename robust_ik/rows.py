"""The six rows of a twist, by name."""

from __future__ import annotations

import reprlib
from collections.abc import Sequence

from robust_ik.errors import InputError

ROWS = ("x", "y", "z", "wx", "wy", "wz")


def checked_rows(rows: Sequence[str]) -> tuple[str, ...]:
    """Some of the six rows, each at most once.

    Raises:
        InputError: They are not; the message says what was given.
    """
    names = tuple(rows) if isinstance(rows, (list, tuple)) else ()
    if not names or any(name not in ROWS for name in names) or len(set(names)) < len(names):
        raise InputError(f"rows must be some of {' '.join(ROWS)}, each at most once, got {reprlib.repr(rows)}")
    return names
