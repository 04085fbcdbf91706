"""Uᵀ (∂J/∂q_k) V of many configurations, without ∂J/∂q: eight side by side, the rest one by one."""

from __future__ import annotations

from robust_ik.checks import Array
from robust_ik.kernels.chain.chain_kinematics import MOST_JOINTS, SIX, TWELVE, place
from robust_ik.kernels.chain.chain_layout import COLUMN, FACTOR, HEAD, INDEPENDENT, JOINTS, STRIDE
from robust_ik.kernels.chain.joint_motion import LOCAL_WORLD_ALIGNED, joint_twists
from robust_ik.kernels.compiler.compiling import WHOLE, called, filled, given, inlined, kernel
from robust_ik.kernels.compiler.simd_lanes import COUNT, Number, spread
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, each_lane, further, lanes_of, pointer, stack


@inlined
def add_cross(x: Number, y: Number, z: Number, b: Pointer, at: int, result: Pointer, to: int, zero: Number) -> None:
    """Adds (x, y, z) × b[at:] to result[to:]."""
    result[to] = result[to] + (y * b[at + 2] - z * b[at + 1])
    result[to + 1] = result[to + 1] + (z * b[at] - x * b[at + 2])
    result[to + 2] = result[to + 2] + (x * b[at + 1] - y * b[at])


@called
def bend(twists: Pointer, motions: Pointer, count: int, bends: Pointer, zero: Number) -> None:
    """Derivatives of the frame's twist Σᵢ motionᵢ (vᵢ, wᵢ) with respect to each joint of the chain, 6 numbers a joint.

    Since ∂vᵢ/∂q_k = w_min(i,k) × v_max(i,k), and ∂wᵢ/∂q_k = w_k × wᵢ for k < i, else 0, it needs only the sums over the
    joints before k and from k on. This holds for sliding joints too, whose w is 0.

    Source: Almarkhi-Maciejewski, eq. (9), with p_i in the branch k < i.
    """
    x, y, z = zero, zero, zero
    for k in range(count):
        at, motion = 6 * k, motions[k]
        for r in range(6):
            bends[at + r] = zero
        add_cross(x, y, z, twists, at, bends, at, zero)
        x, y, z = x + motion * twists[at + 3], y + motion * twists[at + 4], z + motion * twists[at + 5]
    sums = stack(zero, ONE, SIX)
    for r in range(6):
        sums[r] = zero
    for k in range(count - 1, -1, -1):
        at, motion = 6 * k, motions[k]
        for r in range(6):
            sums[r] = sums[r] + motion * twists[at + r]
        x, y, z = twists[at + 3], twists[at + 4], twists[at + 5]
        add_cross(x, y, z, sums, 0, bends, at, zero)
        add_cross(x, y, z, sums, 3, bends, at + 3, zero)


@called
def contract(
    pack: Pointer, twists: Pointer, left: Pointer, right: Pointer, many: int, size: int, down: int, across: int,
    paired: bool, to: Pointer, count: int, zero: Number,
) -> None:  # fmt: skip
    """Wrenches by the derivatives of twists by motions, of at most as many configurations as a Number has lanes.

    Args:
        pack: The chain.
        twists: Of its joints, "local_world_aligned".
        left: `many` wrenches of each configuration, one after another, 6 numbers each.
        right: `size` joint motions of each, n numbers each.
        many: How many wrenches.
        size: How many motions.
        down: Rows of the result from one wrench to the next.
        across: Rows of it from one motion to the next.
        paired: Combine the i-th wrench with the i-th motion only.
        to: Filled, rows of n numbers, as many as are combined.
        count: How many configurations.
        zero: 0 of one number, or of lanes.
    """
    L, joints, n = lanes_of(zero), int(pack[JOINTS]), int(pack[INDEPENDENT])
    motions, bends, wrench, total = (
        stack(zero, ONE, MOST_JOINTS),
        stack(zero, MOST_JOINTS, SIX),
        stack(zero, ONE, SIX),
        stack(zero, ONE, ONE),
    )
    motion, entry, found = each_lane(motions), each_lane(wrench), each_lane(total)
    width = (size if paired else many * size) * n
    for i in range(joints):
        motions[i] = zero
    for r in range(6):
        wrench[r] = zero
    for x in range(count * width):
        to[x] = 0.0
    for b in range(size):
        for lane in range(count):
            for i in range(joints):
                at = HEAD + i * STRIDE
                motion[i * L + lane] = pack[at + FACTOR] * right[(lane * size + b) * n + int(pack[at + COLUMN])]
        bend(twists, motions, joints, bends, zero)
        for a in range(b if paired else 0, b + 1 if paired else many):
            for lane in range(count):
                for r in range(6):
                    entry[r * L + lane] = left[(lane * many + a) * 6 + r]
            for k in range(joints):
                at = HEAD + k * STRIDE
                total[0] = wrench[0] * bends[6 * k]
                for r in range(1, 6):
                    total[0] = total[0] + wrench[r] * bends[6 * k + r]
                for lane in range(count):
                    x = lane * width + (a * down + b * across) * n + int(pack[at + COLUMN])
                    to[x] += pack[at + FACTOR] * found[lane]


@inlined
def some_contractions(
    pack: Pointer, q: Array, left: Array, right: Array, paired: int, result: Array, begin: int, count: int, zero: Number
) -> None:
    """`contractions` of q[begin : begin + count]: at most as many as a Number has lanes."""
    many, size, n = left.shape[1], right.shape[1], right.shape[2]
    twists, end = stack(zero, MOST_JOINTS, SIX), stack(zero, ONE, TWELVE)
    place(pack, further(pointer(q), begin * q.shape[1]), count, twists, end, zero)
    joint_twists(pack, twists, end, twists, LOCAL_WORLD_ALIGNED, zero)
    contract(
        pack, twists, further(pointer(left), begin * many * 6), further(pointer(right), begin * size * n), many, size,
        0 if paired else size, 1, paired != 0, further(pointer(result), begin * result.shape[1] * n), count, zero,
    )  # fmt: skip


@kernel(given(1), given(2), given(3), given(3), WHOLE, filled(3))
def contractions(pack: Array, q: Array, left: Array, right: Array, paired: int, result: Array) -> None:
    """Fills result (N, a b, n) for configurations (N, nq), wrenches (N, a, 6) and joint motions (N, b, n).

    Row i · b + j belongs to wrench i and motion j. If they are paired, a = b, and row i belongs to the i-th pair.
    """
    chain, begin = pointer(pack), 0
    while len(q) - begin >= COUNT:
        some_contractions(chain, q, left, right, paired, result, begin, COUNT, spread(0.0))
        begin += COUNT
    for e in range(begin, len(q)):
        some_contractions(chain, q, left, right, paired, result, e, 1, 0.0)
