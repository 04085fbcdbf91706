"""Starts on the boundary of the reachable poses: the closest configurations to random poses that are out of reach."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, W8, W16, Pointer, sizes, stack
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kernels.pose.damped_step import step
from robust_ik.kernels.pose.error_hessian import curvature
from robust_ik.kernels.pose.newton_polish import ROOM, SIX, TWELVE, look, newton_step, polish
from robust_ik.kernels.pose.starts.random_values import random, random_values
from robust_ik.kernels.pose.symmetric_pose import describe_normal

SHORTEST, LONGEST = 0.05, 0.4
"""Least and largest displacement of a position, as a fraction of the distance that the links span.

Chosen: larger ones lead to few places, smaller ones stay in reach.
"""
TURNED = 0.5
"""Largest rotation of a pose, rad."""
OUTSIDE = 1e-3
"""Least distance of a pose to the closest one reached to count as out of reach, m and rad.

Chosen: nearer ones can hardly be told from reached ones.
"""
STATIONARY = 1e-6
"""Largest gradient at the closest pose, over the distance. Chosen: well polished solutions are far below."""
DEFINITE = 3e-4
"""Least curvature of the pose inwards for every joint motion, m or rad per rad² or m²."""
BEYOND = 0.02
"""Displacement outwards of a pose, m and rad, that other configurations must not reach."""
STARTS, STEPS = 6, 20
"""Starts and damped steps of the search for other configurations.

Chosen: more reject more poses that are not on the boundary, but take longer.
"""
TOLERANCE = 1e-8
"""Tolerance of closest poses, m and rad; also the E, so 1e-4 m and rad, below which BEYOND counts as reached."""
OPTIONS = sizes(lay.OPTIONS)


@called
def onto_boundary(problem: Pointer, number: int, values: Pointer, normal: Pointer) -> bool:
    """Finds a configuration on the boundary of the reachable poses, with no joint at a limit.

    The pose a little outwards must not be reached by other configurations either.

    Args:
        problem: See `pose_layout`.
        number: Number of the try, for its random numbers.
        values: Filled with the joint values.
        normal: Filled with the direction outwards, see `describe_normal`.

    Returns:
        Whether the try succeeded.
    """
    k, options, target = int(problem[lay.COUNT]), stack(0.0, ONE, OPTIONS), stack(0.0, ONE, TWELVE)
    options[lay.POSITION_TOLERANCE], options[lay.ROTATION_TOLERANCE], options[lay.SCALE] = TOLERANCE, TOLERANCE, 1.0
    axes, end, error = stack(0.0, ROOM, SIX), stack(0.0, ONE, TWELVE), stack(0.0, ONE, TWELVE)
    H, g, free, d = stack(0.0, W16, W16), stack(0.0, ONE, W16), stack(0.0, ONE, W16), stack(0.0, ONE, W16)
    random_values(problem, 1, number, 0.0, values)
    for x in range(12):
        target[x] = 0.0
    look(problem, values, target, axes, end, error)
    push(problem, number, end, target)
    polish(problem, options, values, target, error)
    far = math.sqrt(error[6] + error[7])
    if not far > OUTSIDE:
        return False
    look(problem, values, target, axes, end, error)
    curvature(problem, axes, end, target, error, 1.0, H, g)
    for j in range(k):
        at = lay.HEAD + j * lay.STRIDE
        held = values[j] <= problem[at + lay.LOWER] or values[j] >= problem[at + lay.UPPER]
        if held or abs(g[j]) > STATIONARY * far:
            return False
        H[17 * j] -= DEFINITE * far
        free[j] = 1.0
    if not newton_step(H, g, free, 0.0, k, d):
        return False
    for r in range(6):
        error[r] /= far
    describe_normal(problem, end, error, normal)
    for r in range(6):
        error[r] *= BEYOND
    displace(end, error, target)
    return not reached_elsewhere(problem, target, number)


@called
def push(problem: Pointer, number: int, pose: Pointer, target: Pointer) -> None:
    """Displaces a pose at random and turns it a little, to where it may be out of reach.

    Even numbers move it away from the point where the links begin, odd ones in a random direction.
    """
    motion, far, about = stack(0.0, ONE, W8), 0.0, 0.0
    for r in range(3):
        motion[r] = random(3, 16 * number + r) - 0.5
        if number % 2 == 0:
            motion[r] = pose[9 + r] - problem[lay.CENTRE + r]
        motion[3 + r] = random(3, 16 * number + 3 + r) - 0.5
        far, about = far + motion[r] * motion[r], about + motion[3 + r] * motion[3 + r]
    length = problem[lay.BOUND] * (SHORTEST + (LONGEST - SHORTEST) * random(3, 16 * number + 6))
    angle = TURNED * random(3, 16 * number + 7)
    for r in range(3):
        motion[r] *= length / math.sqrt(max(far, 1e-300))
        motion[3 + r] *= angle / math.sqrt(max(about, 1e-300))
    displace(pose, motion, target)


@called
def displace(pose: Pointer, motion: Pointer, target: Pointer) -> None:
    """Displaces a pose by a motion: a position and a rotation vector, world axes."""
    x, y, z = motion[3], motion[4], motion[5]
    square = x * x + y * y + z * z
    theta = math.sqrt(square)
    s = math.sin(theta) / theta if theta > 0.0 else 1.0
    c = (1.0 - math.cos(theta)) / square if square > 0.0 else 0.5
    for column in range(3):
        # v + sin θ/θ w × v + (1 − cos θ)/θ² w × (w × v)
        v0, v1, v2 = pose[column], pose[3 + column], pose[6 + column]
        a0, a1, a2 = y * v2 - z * v1, z * v0 - x * v2, x * v1 - y * v0
        target[column] = v0 + s * a0 + c * (y * a2 - z * a1)
        target[3 + column] = v1 + s * a1 + c * (z * a0 - x * a2)
        target[6 + column] = v2 + s * a2 + c * (x * a1 - y * a0)
    for r in range(3):
        target[9 + r] = pose[9 + r] + motion[r]


@called
def reached_elsewhere(problem: Pointer, target: Pointer, number: int) -> bool:
    """Whether damped steps from a few random configurations reach a target."""
    values, moving, J = stack(0.0, ONE, W16), stack(0.0, ONE, ONE), stack(0.0, W16, W8)
    axes, end, error = stack(0.0, ROOM, SIX), stack(0.0, ONE, TWELVE), stack(0.0, ONE, TWELVE)
    moving[0] = 1.0
    for start in range(STARTS):
        random_values(problem, 4, STARTS * number + start, 0.0, values)
        for _ in range(STEPS):
            look(problem, values, target, axes, end, error)
            if error[6] + error[7] < TOLERANCE:
                return True
            step(problem, values, axes, end, error, 1.0, J, moving, 0.0)
    return False
