"""Pose of a chain's frame and twists of its joints, for one configuration or for eight."""

from __future__ import annotations

import math

from robust_ik.kernels.chain.chain_layout import (
    CIRCLING,
    COLUMN,
    FACTOR,
    FOLLOWING,
    HEAD,
    JOINTS,
    KIND,
    ORIGIN,
    PLACE,
    ROTATION,
    SHIFT,
    SLIDING,
    STRIDE,
)  # fmt: skip
from robust_ik.kernels.chain.sine_cosine import cosines_and_sines, near
from robust_ik.kernels.compiler.compiling import inlined
from robust_ik.kernels.compiler.simd_lanes import Number
from robust_ik.kernels.compiler.stack_memory import Pointer
from robust_ik.kernels.matrices.vectors import mixed, plus, three_of, turned, vector

LOCAL_WORLD_ALIGNED, LOCAL, WORLD = 0, 1, 2
"""Codes of the frames in which twists are expressed: their places in `kinematics.chain.REFERENCES`."""


@inlined
def read_motions(pack: Pointer, q: Pointer, motions: Pointer, lane: int, lanes: int) -> None:
    """Reads the angle or length of every joint, from one configuration into one lane."""
    for i in range(int(pack[JOINTS])):
        at = HEAD + i * STRIDE
        kind, place = pack[at + KIND], int(pack[at + PLACE])
        value = q[place]
        if kind >= FOLLOWING:
            value = math.atan2(q[place + 1], value)
        motion = pack[at + FACTOR] * value + pack[at + SHIFT]
        motions[i * lanes + lane] = motion if kind == SLIDING or kind == SLIDING + FOLLOWING else near(motion)


@inlined
def read_circles(pack: Pointer, q: Pointer, cosines: Pointer, sines: Pointer, lane: int, lanes: int) -> None:
    """Reads cosine and sine of the joints for which q holds them, over the ones computed from angles."""
    for i in range(int(pack[JOINTS])):
        at = HEAD + i * STRIDE
        if pack[at + KIND] == CIRCLING:
            place = int(pack[at + PLACE])
            cosines[i * lanes + lane], sines[i * lanes + lane] = q[place], q[place + 1]


@inlined
def move(
    pack: Pointer, motions: Pointer, cosines: Pointer, sines: Pointer, axes: Pointer, end: Pointer, zero: Number
) -> None:
    """Axes of the joints and the pose of the frame, in world axes.

    Args:
        pack: The chain.
        motions: The motion of each joint.
        cosines: Cosines of the motions of joints that turn.
        sines: Their sines.
        axes: Filled with the unit vector and the origin of each axis, 6 numbers a joint.
        end: Filled with the frame's rotation, row by row, and its origin, 12 numbers.
        zero: 0 as one number, or as eight lanes.
    """
    one = zero + 1.0
    u, v, w, p = vector(one, zero, zero), vector(zero, one, zero), vector(zero, zero, one), vector(zero, zero, zero)
    count = int(pack[JOINTS])
    for i in range(count + 1):
        at = HEAD + i * STRIDE
        r = at + ROTATION
        o = at + ORIGIN
        p = plus(p, mixed(u, pack[o], v, pack[o + 1], w, pack[o + 2]), 1.0)
        x = mixed(u, pack[r], v, pack[r + 3], w, pack[r + 6])
        y = mixed(u, pack[r + 1], v, pack[r + 4], w, pack[r + 7])
        w = mixed(u, pack[r + 2], v, pack[r + 5], w, pack[r + 8])
        u, v = x, y
        if i < count:
            axes[6 * i], axes[6 * i + 1], axes[6 * i + 2] = three_of(w)
            axes[6 * i + 3], axes[6 * i + 4], axes[6 * i + 5] = three_of(p)
            kind = pack[at + KIND]
            if kind == SLIDING or kind == SLIDING + FOLLOWING:
                p = plus(p, w, motions[i])
            else:
                u, v = turned(u, v, cosines[i], sines[i])
    end[0], end[3], end[6] = three_of(u)
    end[1], end[4], end[7] = three_of(v)
    end[2], end[5], end[8] = three_of(w)
    end[9], end[10], end[11] = three_of(p)


@inlined
def joint_twists(pack: Pointer, axes: Pointer, end: Pointer, twists: Pointer, reference: int, zero: Number) -> None:
    """Twist of the frame per unit speed of each joint of the chain: linear, then angular, 6 numbers a joint.

    Args:
        pack: The chain.
        axes: From `move`.
        end: From `move`.
        twists: Filled; may be `axes` itself.
        reference: LOCAL_WORLD_ALIGNED (the frame's point, world axes), LOCAL (its axes) or WORLD (the world's origin).
        zero: 0 as one number, or as eight lanes.
    """
    x, y, z = end[9], end[10], end[11]
    if reference == WORLD:
        x, y, z = zero, zero, zero
    for i in range(int(pack[JOINTS])):
        at = 6 * i
        kind = pack[HEAD + i * STRIDE + KIND]
        u, v, w = axes[at], axes[at + 1], axes[at + 2]
        l0, l1, l2, w0, w1, w2 = u, v, w, zero, zero, zero
        if kind != SLIDING and kind != SLIDING + FOLLOWING:
            d, e, f = x - axes[at + 3], y - axes[at + 4], z - axes[at + 5]
            l0, l1, l2 = v * f - w * e, w * d - u * f, u * e - v * d
            w0, w1, w2 = u, v, w
        if reference == LOCAL:
            l0, l1, l2 = _into(end, l0, l1, l2)
            w0, w1, w2 = _into(end, w0, w1, w2)
        twists[at], twists[at + 1], twists[at + 2] = l0, l1, l2
        twists[at + 3], twists[at + 4], twists[at + 5] = w0, w1, w2


@inlined
def _into(end: Pointer, x: Number, y: Number, z: Number) -> tuple[Number, Number, Number]:
    """Components of a world vector in the frame's own axes."""
    return (
        end[0] * x + end[3] * y + end[6] * z,
        end[1] * x + end[4] * y + end[7] * z,
        end[2] * x + end[5] * y + end[8] * z,
    )


@inlined
def add_columns(pack: Pointer, twists: Pointer, J: Pointer, width: int) -> None:
    """Adds the joints' twists to the columns of the independent joints, in 6 rows of `width`."""
    for i in range(int(pack[JOINTS])):
        at = HEAD + i * STRIDE
        column, factor = int(pack[at + COLUMN]), pack[at + FACTOR]
        for r in range(6):
            J[r * width + column] = J[r * width + column] + factor * twists[6 * i + r]


@inlined
def place_frame(
    pack: Pointer, motions: Pointer, cosines: Pointer, sines: Pointer, axes: Pointer, end: Pointer, zero: Number
) -> None:
    """`move` from motions alone, for a chain of which q holds no cosines and sines."""
    cosines_and_sines(motions, cosines, sines, int(pack[JOINTS]))
    move(pack, motions, cosines, sines, axes, end, zero)
