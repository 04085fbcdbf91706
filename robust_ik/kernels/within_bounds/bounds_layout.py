"""Sizes of what points within bounds are found in."""

from __future__ import annotations

UNKNOWNS = 40
"""Most unknowns of a projection: as many as joints and one more, or joints and rows below their floors."""


def scratch_of(n: int, count: int) -> int:
    """How many numbers of scratch `feasible_start` needs for n joints and `count` rows."""
    short = max(min(count, UNKNOWNS - n), 0)
    rows = n + count + 2 * short
    return count * (n + 2) + rows * (n + short) + n + rows
