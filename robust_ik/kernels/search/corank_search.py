"""The search for configurations of a corank: all steps of many searches, eight side by side.

A search that has ended makes room for the next one. What becomes of it does not depend on those beside it.
"""

from __future__ import annotations

import math

from robust_ik.checks import Array
from robust_ik.kernels.chain.chain_kinematics import MOST_JOINTS, SIX, TWELVE, place
from robust_ik.kernels.chain.chain_layout import COLUMN, FACTOR, HEAD, INDEPENDENT, JOINTS, STRIDE
from robust_ik.kernels.chain.hessian_contraction import contract
from robust_ik.kernels.chain.joint_motion import LOCAL_WORLD_ALIGNED, joint_twists
from robust_ik.kernels.compiler.compiling import WHOLE, called, filled, given, inlined, kernel
from robust_ik.kernels.compiler.simd_lanes import Number, spread
from robust_ik.kernels.compiler.stack_memory import (
    ONE,
    W8,
    W16,
    Pointer,
    Sizes,
    each_lane,
    further,
    lanes_of,
    pointer,
    sizes,
    stack,
)
from robust_ik.kernels.matrices.levenberg_marquardt import damped_step
from robust_ik.kernels.matrices.small_svd import TOGETHER, decompose_few
from robust_ik.kernels.search.corank_search_layout import (
    FIRST,
    LEAST_SCALE,
    LESS,
    LONGEST,
    MORE,
    PATIENCE,
    SIDE_BY_SIDE,
    STEPS,
    TOLERANCE,
    WORTHWHILE,
)

NORM, SCALE, DAMPING, IDLE = range(4)
"""Places in the state of a search: ‖r‖ where it is, the scale of singular values there, damping, steps in vain."""
STATE = sizes(4)
"""How many there are."""


@called
def task_jacobians(
    pack: Pointer, task: Pointer, m: int, q: Pointer, count: int, twists: Pointer, to: Pointer, zero: Number
) -> None:
    """Jacobians in the task's rows, or their transposes if m > n.

    Args:
        pack: The chain.
        task: Place and factor of each task row.
        m: Number of task rows.
        q: Joint values, (count, n).
        count: How many configurations, at most as many as a Number has lanes.
        twists: Filled: twists of the joints.
        to: Filled, (count, m, n) or (count, n, m).
        zero: 0 of one number, or of lanes.
    """
    L, n = lanes_of(zero), int(pack[INDEPENDENT])
    end, each = stack(zero, ONE, TWELVE), each_lane(twists)
    place(pack, q, count, twists, end, zero)
    joint_twists(pack, twists, end, twists, LOCAL_WORLD_ALIGNED, zero)
    down, across = (n, 1) if m <= n else (1, m)
    for x in range(count * m * n):
        to[x] = 0.0
    for lane in range(count):
        J = further(to, lane * m * n)
        for i in range(int(pack[JOINTS])):
            at = HEAD + i * STRIDE
            column, factor = int(pack[at + COLUMN]), pack[at + FACTOR]
            for r in range(m):
                J[r * down + column * across] += factor * each[(6 * i + int(task[2 * r])) * L + lane]
        for r in range(m):
            for c in range(n):
                J[r * down + c * across] *= task[2 * r + 1]


@called
def weak_directions(
    U: Pointer, Vt: Pointer, task: Pointer, m: int, n: int, kept: int, left: Pointer, right: Pointer
) -> None:
    """The weak left singular vectors as wrenches, and the weak right ones, of a Jacobian whose wider side is in Vt.

    Args:
        U: Of the Jacobian (m, n), or of its transpose if m > n.
        Vt: As U.
        task: Place and factor of each task row.
        m: Number of task rows.
        n: Number of joints.
        kept: How many singular vectors are not weak.
        left: Filled, (m - kept, 6).
        right: Filled, (n - kept, n).
    """
    k = min(m, n)
    for a in range(m - kept):
        for r in range(6):
            left[6 * a + r] = 0.0
        for r in range(m):
            entry = U[r * k + kept + a] if m <= n else Vt[(kept + a) * m + r]
            left[6 * a + int(task[2 * r])] = entry * task[2 * r + 1]
    for b in range(n - kept):
        for c in range(n):
            right[b * n + c] = Vt[(kept + b) * n + c] if m <= n else U[c * k + kept + b]


@called
def residuals(
    pack: Pointer, task: Pointer, m: int, kept: int, q: Pointer, count: int, room: Pointer, s: Pointer, to: Pointer,
    width: Sizes, zero: Number,
) -> bool:  # fmt: skip
    """Singular values and ∂r/∂q of at most as many configurations as a Number has lanes; False if not all is finite.

    Args:
        pack: The chain.
        task: Place and factor of each task row.
        m: Number of task rows.
        kept: How many singular values are not to become zero.
        q: Joint values, (count, n).
        count: How many configurations.
        room: Room.
        s: Filled, (count, min(m, n)).
        to: Filled, (count, p, n).
        width: At least m and n.
        zero: 0 of one number, or of lanes.
    """
    n = int(pack[INDEPENDENT])
    k, long, many, size = min(m, n), max(m, n), m - kept, n - kept
    J = room
    U = further(J, count * m * n)
    Vt = further(U, count * k * k)
    left = further(Vt, count * long * long)
    right = further(left, count * many * 6)
    twists = stack(zero, MOST_JOINTS, SIX)
    task_jacobians(pack, task, m, q, count, twists, J, zero)
    if not decompose_few(J, U, s, Vt, k, long, long, count, width, width, zero):
        return False
    for lane in range(count):
        weak_directions(
            further(U, lane * k * k), further(Vt, lane * long * long), task, m, n, kept,
            further(left, lane * many * 6), further(right, lane * size * n),
        )  # fmt: skip
    down, across = (size, 1) if m <= n else (1, many)
    contract(pack, twists, left, right, many, size, down, across, False, to, count, zero)
    return True


@called
def copy(source: Pointer, count: int, to: Pointer) -> None:
    """Copies `count` numbers."""
    for x in range(count):
        to[x] = source[x]


@called
def settle(rules: Pointer, its: Pointer, tries: float, weakest: Pointer, count: int, sigma: float) -> bool:
    """Counts a step of a search; whether it is taken.

    Args:
        rules: See `corank_search_layout`.
        its: The state of the search.
        tries: Steps tried before; negative if this is the start.
        weakest: The diagonal of r after the step.
        count: How many numbers these are.
        sigma: σ₁ there.
    """
    total = 0.0
    for i in range(count):
        total += weakest[i] * weakest[i]
    after, before = math.sqrt(total), its[NORM]
    taken = tries < 0.0 or after < before
    if tries < 0.0:
        its[DAMPING], its[IDLE] = rules[FIRST], 0.0
    else:
        its[DAMPING] *= rules[LESS] if taken else rules[MORE]
        its[IDLE] = 0.0 if after < rules[WORTHWHILE] * before else its[IDLE] + 1.0
    if taken:
        its[NORM], its[SCALE] = after, max(sigma, rules[LEAST_SCALE])
    return taken


@inlined
def going(rules: Pointer, its: Pointer, tries: float) -> bool:
    """Whether a search goes on."""
    relative = its[NORM] / (its[SCALE] if its[SCALE] > 0.0 else 1.0)
    goes: bool = relative > rules[TOLERANCE] and its[IDLE] < rules[PATIENCE] and tries < rules[STEPS]
    return goes


@called
def search(
    pack: Array, task: Array, rules: Array, kept: int, room: Array, q: Array, s: Array, derivative: Array,
    scale: Array, tries: Array, width: Sizes,
) -> bool:  # fmt: skip
    """Levenberg-Marquardt steps from each q until r vanishes or no step helps; False if not all is finite.

    Args:
        pack: The chain.
        task: Place in a whole Jacobian and factor of each task row, (m, 2).
        rules: See `corank_search_layout`.
        kept: How many singular values are not to become zero.
        room: As many numbers as `corank_search_layout.room` says.
        q: Joint values at the start, then at the end, (N, n).
        s: Filled: the singular values there, (N, min(m, n)).
        derivative: Filled: ∂r/∂q there, (N, p, n).
        scale: Filled: the scale of singular values there, (N,).
        tries: Filled: steps tried, (N,).
        width: At least m and n.
    """
    chain, rows, told, m, n = pointer(pack), pointer(task), pointer(rules), len(task), q.shape[1]
    k, p, weak = s.shape[1], derivative.shape[1], s.shape[1] - kept
    trial = pointer(room)
    its_s = further(trial, SIDE_BY_SIDE * n)
    its_slope = further(its_s, SIDE_BY_SIDE * k)
    gram = further(its_slope, SIDE_BY_SIDE * p * n)
    x = further(gram, min(p, n) * min(p, n))
    step = further(x, min(p, n))
    rest = further(step, n)
    which, state = stack(0.0, ONE, W8), stack(0.0, W8, STATE)
    begin, count = 0, 0
    while True:
        while count < SIDE_BY_SIDE and begin < len(q):
            copy(further(pointer(q), begin * n), n, further(trial, count * n))
            which[count], tries[begin] = begin, -1.0  # its start has not been looked at
            begin, count = begin + 1, count + 1
        if count == 0:
            return True
        good = True
        if count >= TOGETHER:
            good = residuals(chain, rows, m, kept, trial, count, rest, its_s, its_slope, width, spread(0.0))
        else:
            for lane in range(count):
                good &= residuals(
                    chain, rows, m, kept, further(trial, lane * n), 1, rest, further(its_s, lane * k),
                    further(its_slope, lane * p * n), width, 0.0,
                )  # fmt: skip
        if not good:
            return False
        for lane in range(count - 1, -1, -1):
            e, its, new_s = int(which[lane]), further(state, lane * len(STATE)), further(its_s, lane * k)
            to_q, to_s = further(pointer(q), e * n), further(pointer(s), e * k)
            to_slope = further(pointer(derivative), e * p * n)
            if settle(told, its, tries[e], further(new_s, kept), weak, new_s[0]):
                copy(further(trial, lane * n), n, to_q)
                copy(new_s, k, to_s)
                copy(further(its_slope, lane * p * n), p * n, to_slope)
                scale[e] = its[SCALE]
            tries[e] += 1.0
            if going(told, its, tries[e]):
                mu = its[DAMPING] * its[NORM] * its[SCALE]
                damped_step(to_slope, further(to_s, kept), p, n, weak, mu, told[LONGEST], gram, x, step)
                for c in range(n):
                    trial[lane * n + c] = to_q[c] + step[c]
            else:
                count -= 1  # its place is taken by the last one, which has had its turn
                which[lane] = which[count]
                copy(further(state, count * len(STATE)), len(STATE), its)
                copy(further(trial, count * n), n, further(trial, lane * n))


SEARCH = given(1), given(2), given(1), WHOLE, filled(1), filled(2), filled(2), filled(3), filled(1), filled(1)


@kernel(*SEARCH)
def searches_8(
    pack: Array, task: Array, rules: Array, kept: int, room: Array, q: Array, s: Array, derivative: Array,
    scale: Array, tries: Array,
) -> bool:  # fmt: skip
    """`search` with at most 8 task rows and joints."""
    return search(pack, task, rules, kept, room, q, s, derivative, scale, tries, W8)


@kernel(*SEARCH)
def searches_16(
    pack: Array, task: Array, rules: Array, kept: int, room: Array, q: Array, s: Array, derivative: Array,
    scale: Array, tries: Array,
) -> bool:  # fmt: skip
    """`search` with at most 16 task rows and joints."""
    return search(pack, task, rules, kept, room, q, s, derivative, scale, tries, W16)
