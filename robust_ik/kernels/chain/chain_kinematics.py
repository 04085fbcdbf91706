"""Poses, Jacobians and Hessians of many configurations: eight side by side, the rest one by one."""

from __future__ import annotations

from robust_ik.checks import Array
from robust_ik.kernels.chain.chain_layout import COLUMN, CONFIGURATION, FACTOR, HEAD, JOINTS, STRIDE
from robust_ik.kernels.chain.joint_motion import LOCAL, WORLD, joint_twists, move, read_circles, read_motions
from robust_ik.kernels.chain.sine_cosine import cosines_and_sines
from robust_ik.kernels.compiler.compiling import WHOLE, called, filled, given, inlined, kernel
from robust_ik.kernels.compiler.simd_lanes import COUNT, Number, spread
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, each_lane, further, lanes_of, pointer, sizes, stack

MOST_JOINTS = sizes(208)
"""Room for the joints of a chain: a robot has at most 200, and their sines are computed eight at a time."""
SIX, TWELVE = sizes(6), sizes(12)


@called
def place(pack: Pointer, q: Pointer, count: int, axes: Pointer, end: Pointer, zero: Number) -> None:
    """Axes and frames of `count` configurations from pointer q on: at most as many as a Number has lanes."""
    L, c, nq = lanes_of(zero), int(pack[JOINTS]), int(pack[CONFIGURATION])
    motions, cosines = stack(zero, ONE, MOST_JOINTS), stack(zero, ONE, MOST_JOINTS)
    sines = stack(zero, ONE, MOST_JOINTS)
    for i in range((c + 7) // 8 * 8):
        motions[i] = zero
    for lane in range(count):
        read_motions(pack, further(q, lane * nq), each_lane(motions), lane, L)
    cosines_and_sines(motions, cosines, sines, c)
    for lane in range(count):
        read_circles(pack, further(q, lane * nq), each_lane(cosines), each_lane(sines), lane, L)
    move(pack, motions, cosines, sines, axes, end, zero)


@inlined
def some_poses(pack: Pointer, q: Array, T: Array, begin: int, count: int, zero: Number) -> None:
    """`poses` of q[begin : begin + count]: at most as many as a Number has lanes."""
    L = lanes_of(zero)
    axes, end = stack(zero, MOST_JOINTS, SIX), stack(zero, ONE, TWELVE)
    place(pack, further(pointer(q), begin * q.shape[1]), count, axes, end, zero)
    entry = each_lane(end)
    for lane in range(count):
        e = begin + lane
        for r in range(3):
            for c in range(3):
                T[e, r, c] = entry[(3 * r + c) * L + lane]
            T[e, r, 3], T[e, 3, r] = entry[(9 + r) * L + lane], 0.0
        T[e, 3, 3] = 1.0


@kernel(given(1), given(2), filled(3))
def poses(pack: Array, q: Array, T: Array) -> None:
    """Fills T[e] with the pose at q[e]."""
    chain, begin = pointer(pack), 0
    while len(q) - begin >= COUNT:
        some_poses(chain, q, T, begin, COUNT, spread(0.0))
        begin += COUNT
    for e in range(begin, len(q)):
        some_poses(chain, q, T, e, 1, 0.0)


@inlined
def some_jacobians(pack: Pointer, q: Array, J: Array, begin: int, count: int, reference: int, zero: Number) -> None:
    """`jacobians` of q[begin : begin + count]: at most as many as a Number has lanes."""
    L = lanes_of(zero)
    axes, end = stack(zero, MOST_JOINTS, SIX), stack(zero, ONE, TWELVE)
    place(pack, further(pointer(q), begin * q.shape[1]), count, axes, end, zero)
    joint_twists(pack, axes, end, axes, reference, zero)
    twists = each_lane(axes)
    for lane in range(count):
        e = begin + lane
        for r in range(6):
            for c in range(J.shape[2]):
                J[e, r, c] = 0.0
        for i in range(int(pack[JOINTS])):
            at = HEAD + i * STRIDE
            column, factor = int(pack[at + COLUMN]), pack[at + FACTOR]
            for r in range(6):
                J[e, r, column] += factor * twists[(6 * i + r) * L + lane]


@kernel(given(1), given(2), filled(3), WHOLE)
def jacobians(pack: Array, q: Array, J: Array, reference: int) -> None:
    """Fills J[e] with the Jacobian at q[e]."""
    chain, begin = pointer(pack), 0
    while len(q) - begin >= COUNT:
        some_jacobians(chain, q, J, begin, COUNT, reference, spread(0.0))
        begin += COUNT
    for e in range(begin, len(q)):
        some_jacobians(chain, q, J, e, 1, reference, 0.0)


@kernel(given(1), given(2), filled(4), WHOLE)
def hessians(pack: Array, q: Array, H: Array, reference: int) -> None:
    """Fills H[e, r, j, k] = ∂J_rj/∂q_k at q[e].

    With twists (v, w) of the joints along the chain, in the world's reference ∂S_i/∂q_k = [S_k, S_i] for k < i, in the
    frame's own [S_i, S_k] for k > i, else 0; aligned with the world, ∂v_i/∂q_k = w_min(i,k) × v_max(i,k) and
    ∂w_i/∂q_k = w_k × w_i for k < i, else 0.

    Source: Murray, Li, Sastry 1994, section 3.4; Almarkhi-Maciejewski, eq. (9), with p_i in the branch k < i.
    """
    chain = pointer(pack)
    count = int(chain[JOINTS])
    axes, end, slope = stack(0.0, MOST_JOINTS, SIX), stack(0.0, ONE, TWELVE), stack(0.0, ONE, SIX)
    for e in range(len(q)):
        place(chain, further(pointer(q), e * q.shape[1]), 1, axes, end, 0.0)
        joint_twists(chain, axes, end, axes, reference, 0.0)
        H[e] = 0.0
        for i in range(count):
            for k in range(count):
                slope_of(axes, i, k, reference, slope)
                row, column = HEAD + i * STRIDE, HEAD + k * STRIDE
                factor = chain[row + FACTOR] * chain[column + FACTOR]
                for r in range(6):
                    H[e, r, int(chain[row + COLUMN]), int(chain[column + COLUMN])] += factor * slope[r]


@called
def slope_of(twists: Pointer, i: int, k: int, reference: int, slope: Pointer) -> None:
    """∂(v_i, w_i)/∂q_k for joints of the chain."""
    for r in range(6):
        slope[r] = 0.0
    first, second = min(i, k), max(i, k)
    if reference == WORLD:
        if k < i:
            _add_cross(twists, 6 * k + 3, twists, 6 * i, slope, 0)
            _add_cross(twists, 6 * k, twists, 6 * i + 3, slope, 0)
            _add_cross(twists, 6 * k + 3, twists, 6 * i + 3, slope, 3)
    elif reference == LOCAL:
        if k > i:
            _add_cross(twists, 6 * i + 3, twists, 6 * k, slope, 0)
            _add_cross(twists, 6 * i, twists, 6 * k + 3, slope, 0)
            _add_cross(twists, 6 * i + 3, twists, 6 * k + 3, slope, 3)
    else:
        _add_cross(twists, 6 * first + 3, twists, 6 * second, slope, 0)
        if k < i:
            _add_cross(twists, 6 * k + 3, twists, 6 * i + 3, slope, 3)


@inlined
def _add_cross(a: Pointer, i: int, b: Pointer, j: int, result: Pointer, at: int) -> None:
    """Adds a[i:] × b[j:] to result[at:]."""
    result[at] += a[i + 1] * b[j + 2] - a[i + 2] * b[j + 1]
    result[at + 1] += a[i + 2] * b[j] - a[i] * b[j + 2]
    result[at + 2] += a[i] * b[j + 1] - a[i + 1] * b[j]
