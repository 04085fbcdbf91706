"""Layout of what the compiled search for singular configurations is given."""

from __future__ import annotations

TOLERANCE, STEPS, LONGEST, FIRST, LESS, MORE, WORTHWHILE, PATIENCE, LEAST_SCALE = range(9)
"""Places of the rules of a search: those of `singularities.find.projection_search`, and the least scale of σ₁."""
SIDE_BY_SIDE = 8
"""Searches that have room at once: as many as lanes."""


def room(m: int, n: int, a: int, b: int) -> int:
    """Numbers that are worked on, for Jacobians (m, n) with a left and b right singular vectors that are weak."""
    k, long, residual = min(m, n), max(m, n), a * b * n
    step = min(a * b, n) * (min(a * b, n) + 1)
    return SIDE_BY_SIDE * (n + m * n + k * k + long * long + k + a * 6 + b * n + residual) + step + n
