"""Checks whether a target is valid, and whether it is farther away than the links reach."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import Pointer
from robust_ik.kernels.pose import pose_layout as lay

RIGID, UNIT = 1e-6, 1e-6
"""Largest entry of |R Rᵀ − 1|, and largest difference of a (cos, sin) from length 1: as `checks`, `robot.joint_map`."""
FARTHEST = 1e9
"""A position or joint value beyond this is refused, m or rad. Chosen: doubles there are 1e-7 apart."""
MARGIN = 1e-9
"""Relative margin of the bound, for rounding."""


@called
def sound(problem: Pointer, target: Pointer, q0: Pointer) -> bool:
    """Whether a target is a rigid pose and q0 is finite, with cosines and sines of length 1."""
    good = target[12] == 0.0 and target[13] == 0.0 and target[14] == 0.0 and target[15] == 1.0
    for r in range(3):
        good = good and abs(target[4 * r + 3]) <= FARTHEST
        for c in range(3):
            entry = -1.0 if r == c else 0.0
            for k in range(3):
                entry += target[4 * r + k] * target[4 * c + k]
            good = good and abs(entry) <= RIGID
    volume = 0.0
    for c in range(3):
        one, two = 4 + (c + 1) % 3, 4 + (c + 2) % 3
        volume += target[c] * (target[one] * target[two + 4] - target[two] * target[one + 4])
    good = good and volume > 0.0
    for x in range(int(problem[lay.LENGTH])):
        good = good and abs(q0[x]) <= FARTHEST
    for j in range(int(problem[lay.COUNT])):
        at = lay.HEAD + j * lay.STRIDE
        place = int(problem[at + lay.PLACE])
        if problem[at + lay.CIRCLE] > 0.0:
            good = good and abs(math.sqrt(q0[place] ** 2 + q0[place + 1] ** 2) - 1.0) <= UNIT
    return bool(good)


@called
def unreachable(problem: Pointer, target: Pointer) -> bool:
    """Whether a target is farther away than the links are long, see `lay.BOUND`."""
    square = 0.0
    for r in range(3):
        d = target[9 + r] - problem[lay.CENTRE + r]
        if problem[lay.TURN] == lay.FULL:
            for c in range(3):
                d += target[3 * r + c] * problem[lay.CARRIED + c]
        d *= problem[lay.ROWS + r]
        square += d * d
    return bool(square > (problem[lay.BOUND] * (1.0 + MARGIN)) ** 2)
