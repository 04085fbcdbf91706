"""Angles that differ by full turns: the smallest difference, and the value within limits next to another one, rad."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called, inlined

WHOLE = 2.0 * math.pi
"""A full turn, rad."""


@inlined
def unwound(angle: float) -> float:
    """The angle without full turns, in [−π, π] up to rounding."""
    return angle - WHOLE * math.floor(angle / WHOLE + 0.5)


@called
def turned(value: float, near: float, low: float, high: float) -> float:
    """The angle that differs from `value` by full turns and is closest to `near`, then brought above low, below high.

    Where the limits leave less than a turn it may pass `low`.
    """
    value += WHOLE * math.floor((near - value) / WHOLE + 0.5)
    if value < low:
        value += WHOLE * math.ceil((low - value) / WHOLE)
    if value > high:
        value -= WHOLE * math.ceil((value - high) / WHOLE)
    return value
