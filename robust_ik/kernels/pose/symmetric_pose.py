"""A pose without the rotations of the first and last joint, if the first joint turns the arm and the last one the tool.

It consists of radius and height of the last joint's origin about the first joint's axis, and of the last joint's axis.
"""

from __future__ import annotations

import math

from robust_ik.kernels.chain import chain_layout as links
from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, further, sizes, stack
from robust_ik.kernels.pose import pose_layout as lay

NEAR = 1e-9
"""Radius, m, up to which the tool axis gives the azimuth: the azimuth of the position would be rounding."""
TWELVE = sizes(12)


@inlined
def into_first(pack: Pointer, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Components of a world vector in the axis frame of the first joint."""
    r = links.HEAD + links.ROTATION
    return (
        pack[r] * x + pack[r + 3] * y + pack[r + 6] * z,
        pack[r + 1] * x + pack[r + 4] * y + pack[r + 7] * z,
        pack[r + 2] * x + pack[r + 5] * y + pack[r + 8] * z,
    )


@called
def describe(problem: Pointer, pose: Pointer, found: Pointer) -> float:
    """Describes a pose without the rotations of the first and last joint.

    Args:
        problem: See `pose_layout`.
        pose: Rotation, row by row, and position.
        found: Filled with radius, height, tool axis and x axis, 8 numbers.

    Returns:
        The azimuth, rad.
    """
    pack = further(problem, int(problem[lay.CHAIN]))
    last = links.HEAD + int(pack[links.JOINTS]) * links.STRIDE
    # G = R Rₜᵀ and w = p − G oₜ, the axis frame of the last joint.
    G = stack(0.0, ONE, TWELVE)
    for i in range(3):
        for j in range(3):
            G[3 * i + j] = 0.0
            for k in range(3):
                G[3 * i + j] += pose[3 * i + k] * pack[last + links.ROTATION + 3 * j + k]
        G[9 + i] = pose[9 + i] - pack[links.HEAD + links.ORIGIN + i]
        for j in range(3):
            G[9 + i] -= G[3 * i + j] * pack[last + links.ORIGIN + j]
    x, y, z = into_first(pack, G[9], G[10], G[11])
    a0, a1, a2 = into_first(pack, G[2], G[5], G[8])
    b0, b1, b2 = into_first(pack, G[0], G[3], G[6])
    radius = math.sqrt(x * x + y * y)
    azimuth = math.atan2(y, x) if radius > NEAR else math.atan2(a1, a0)
    c, s = math.cos(azimuth), math.sin(azimuth)
    found[0], found[1] = radius, z
    found[2], found[3], found[4] = c * a0 + s * a1, c * a1 - s * a0, a2
    found[5], found[6], found[7] = c * b0 + s * b1, c * b1 - s * b0, b2
    return azimuth


@called
def describe_normal(problem: Pointer, pose: Pointer, push: Pointer, normal: Pointer) -> None:
    """Converts a normal of the pose into one of the 5 numbers of `describe`.

    For every small motion of the pose, both normals have the same product with the change.

    Args:
        problem: See `pose_layout`.
        pose: Rotation, row by row, and position.
        push: Normal of the pose: for position and rotation, world axes, 6 numbers; first and last joint move at right
            angles to it.
        normal: Filled with 5 numbers: for radius, height, and the change of the axis.
    """
    pack = further(problem, int(problem[lay.CHAIN]))
    last = links.HEAD + int(pack[links.JOINTS]) * links.STRIDE
    found, arm, moment = stack(0.0, ONE, TWELVE), stack(0.0, ONE, TWELVE), stack(0.0, ONE, TWELVE)
    azimuth = describe(problem, pose, found)
    for i in range(3):
        # From the last joint's origin to the tool's, G oₜ = R Rₜᵀ oₜ.
        arm[i] = 0.0
        for k in range(3):
            inner = 0.0
            for j in range(3):
                inner += pack[last + links.ROTATION + 3 * j + k] * pack[last + links.ORIGIN + j]
            arm[i] += pose[3 * i + k] * inner
    for i in range(3):
        one, two = (i + 1) % 3, (i + 2) % 3
        moment[i] = push[3 + i] + arm[one] * push[two] - arm[two] * push[one]
    f0, f1, f2 = into_first(pack, push[0], push[1], push[2])
    m0, m1, m2 = into_first(pack, moment[0], moment[1], moment[2])
    c, s = math.cos(azimuth), math.sin(azimuth)
    normal[0], normal[1] = c * f0 + s * f1, f2
    m0, m1 = c * m0 + s * m1, c * m1 - s * m0
    normal[2], normal[3], normal[4] = (
        m1 * found[4] - m2 * found[3],
        m2 * found[2] - m0 * found[4],
        m0 * found[3] - m1 * found[2],
    )
