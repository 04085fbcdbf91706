"""Joint values where a search begins: random ones, and angles turned into the limits.

Each random number is computed from its index, so that it is the same on every thread.

Source: Steele, Lea, Flood 2014: SplitMix64.
"""

from __future__ import annotations

import math

import numpy as np

from robust_ik.kernels.chain.full_turns import WHOLE, turned
from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import Pointer
from robust_ik.kernels.pose import pose_layout as lay

FARTHEST = 1e6
"""An angle is not brought closer to another one beyond this, rad, since it would lose digits."""


@inlined
def random(seed: int, number: int) -> float:
    """The uniform random number in [0, 1) with this seed and index."""
    x = np.uint64(seed) + np.uint64(number + 1) * np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    x = x ^ (x >> np.uint64(31))
    return np.float64(np.int64(x >> np.uint64(11))) * 2.0**-53


@called
def random_values(problem: Pointer, seed: int, start: int, loose: float, values: Pointer) -> None:
    """Joint values of a random start, uniform within the limits.

    The ranges of periodic joints are widened by at most `loose` on each side, rad, and to at most a full turn.
    """
    for j in range(int(problem[lay.COUNT])):
        at = lay.HEAD + j * lay.STRIDE
        low, high = problem[at + lay.FROM], problem[at + lay.TO]
        if loose > 0.0 and problem[at + lay.PERIODIC] > 0.0:
            beyond = min(max(math.pi - 0.5 * (high - low), 0.0), loose)
            low, high = low - beyond, high + beyond
        values[j] = low + (high - low) * random(seed, 16 * start + j)


@called
def within(problem: Pointer, j: int, value: float, near: float) -> float:
    """The angle within the limits of joint j that differs from `value` by full turns and is closest to `near`."""
    at = lay.HEAD + j * lay.STRIDE
    low, high = problem[at + lay.LOWER], problem[at + lay.UPPER]
    if problem[at + lay.PERIODIC] > 0.0:
        near = min(max(near, -FARTHEST, low - WHOLE), FARTHEST, high + WHOLE)
        value = turned(value, near, low, high)
        if value < low and low - value > value + WHOLE - high:
            value += WHOLE
    return float(min(max(value, low), high))
