"""The search for poses, one after the other or eight side by side: measure, decide, step."""

from __future__ import annotations

from typing import Any

from robust_ik.checks import Array
from robust_ik.kernels.compiler.array_handles import int64_at, is_matrix, is_vector, numbers_of
from robust_ik.kernels.compiler.compiling import HANDLE, WHOLE, called, filled, given, kernel
from robust_ik.kernels.compiler.simd_lanes import Number, somewhere, spread
from robust_ik.kernels.compiler.stack_memory import (
    ONE,
    W8,
    W16,
    Pointer,
    at_address,
    each_lane,
    further,
    lanes_of,
    pointer,
    stack,
)
from robust_ik.kernels.loader.array_layout import ALIGNED, CONTIGUOUS
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kernels.pose import search_memory as mem
from robust_ik.kernels.pose.damped_step import step
from robust_ik.kernels.pose.newton_polish import ROOM, SIX, TWELVE
from robust_ik.kernels.pose.pose_error import measure
from robust_ik.kernels.pose.search_decisions import decide, finish
from robust_ik.kernels.pose.search_memory import begin
from robust_ik.kernels.pose.target_checks import sound


@called
def take(
    problem: Pointer, options: Pointer, memory: Pointer, targets: Pointer, e: int, q0: Pointer, values: Pointer
) -> None:
    """Begins the search for target e."""
    for r in range(3):
        for c in range(3):
            memory[mem.AIM + 3 * r + c] = targets[16 * e + 4 * r + c]
        memory[mem.AIM + 9 + r] = targets[16 * e + 4 * r + 3]
    memory[mem.TARGET] = e
    begin(problem, options, memory, q0, values)


@called
def search(
    problem: Pointer,
    options: Pointer,
    targets: Pointer,
    q0: Pointer,
    stride: int,
    q: Pointer,
    room: int,
    numbers: Pointer,
    count: int,
    zero: Number,
) -> None:
    """Searches for `count` targets; a lane that is done takes the next one.

    Args:
        problem: See `pose_layout`.
        options: The same.
        targets: Poses, 16 numbers each.
        q0: Configurations where the searches begin.
        stride: Numbers from one q0 to the next; 0 if there is one for all.
        q: Room for `room` configurations for each target; the first ones are filled.
        room: At least the number of solutions wanted.
        numbers: Filled with results, see `pose_layout`.
        count: Number of targets.
        zero: 0 as one number, or as eight lanes.
    """
    L, length, k = lanes_of(zero), int(problem[lay.LENGTH]), int(problem[lay.COUNT])
    motions, cosines, sines = stack(zero, ONE, ROOM), stack(zero, ONE, ROOM), stack(zero, ONE, ROOM)
    axes, end, error = stack(zero, ROOM, SIX), stack(zero, ONE, TWELVE), stack(zero, ONE, TWELVE)
    values, target = stack(zero, ONE, W16), stack(zero, ONE, TWELVE)
    J, moving, memories = stack(zero, W16, W8), stack(zero, ONE, ONE), stack(zero, ONE, mem.MEMORY)
    own = stack(0.0, ONE, W16)
    for i in range(len(ROOM)):
        motions[i] = zero
    for x in range(12):
        target[x] = zero
    for j in range(len(W16)):
        values[j] = zero
    for lane in range(L):
        further(each_lane(memories), mem.SIZE * lane)[mem.TARGET] = -1.0
    following, active = 0, 0
    while active > 0 or following < count:
        for lane in range(L):
            memory = further(each_lane(memories), mem.SIZE * lane)
            if memory[mem.TARGET] < 0.0 and following < count:
                take(problem, options, memory, targets, following, further(q0, following * stride), own)
                for x in range(12):
                    each_lane(target)[x * L + lane] = memory[mem.AIM + x]
                for j in range(k):
                    each_lane(values)[j * L + lane] = own[j]
                following += 1
                active += 1
        measure(problem, values, target, motions, cosines, sines, axes, end, error, zero)
        for lane in range(L):
            memory = further(each_lane(memories), mem.SIZE * lane)
            e = int(memory[mem.TARGET])
            each_lane(moving)[lane] = 0.0
            if e >= 0:
                for j in range(k):
                    own[j] = each_lane(values)[j * L + lane]
                found = further(q, e * room * length)
                p, r = each_lane(error)[6 * L + lane], each_lane(error)[7 * L + lane]
                verdict = decide(problem, options, memory, own, p, r, found)
                if verdict > 0:
                    each_lane(moving)[lane] = 1.0 + memory[mem.LOOSE]
                elif verdict == 0:
                    for j in range(k):
                        each_lane(values)[j * L + lane] = own[j]
                else:
                    finish(problem, options, memory, further(q0, e * stride), found, further(numbers, e * lay.NUMBERS))
                    memory[mem.TARGET] = -1.0
                    active -= 1
        if somewhere(moving[0] > 0.0):
            step(problem, values, axes, end, error, options[lay.SCALE], J, moving, zero)


@kernel(WHOLE, HANDLE, HANDLE, HANDLE, HANDLE)
def solve_one(setup: int, target: Any, q0: Any, q: Any, numbers: Any) -> bool:
    """Solutions for one target; False if target or q0 are not arrays of doubles of the right shape, or are not valid.

    Args:
        setup: The address of three addresses: of NumPy's array class, of the problem, of the options.
        target: Array (4, 4).
        q0: Array (nq,).
        q: Array with room for as many configurations as are wanted; not checked.
        numbers: Array with room for results, see `pose_layout`; not checked.
    """
    array_class, problem, options = int64_at(setup), at_address(int64_at(setup + 8)), at_address(int64_at(setup + 16))
    plain, length = CONTIGUOUS | ALIGNED, int(problem[lay.LENGTH])
    if not (is_matrix(target, array_class, 4, 4, plain) and is_vector(q0, array_class, length, plain)):
        return False
    aim, begin, wanted = numbers_of(target), numbers_of(q0), int(options[lay.WANTED])
    if not sound(problem, aim, begin):
        return False
    search(problem, options, aim, begin, 0, numbers_of(q), wanted, numbers_of(numbers), 1, 0.0)
    return True


@kernel(given(1), given(1), given(3), given(2), filled(3), filled(2))
def solve_many(problem: Array, options: Array, targets: Array, q0: Array, q: Array, numbers: Array) -> None:
    """Solutions for many valid targets, into q[e, 0], q[e, 1], ...; eight side by side."""
    stride = q0.shape[1] if len(q0) > 1 else 0
    search(
        pointer(problem), pointer(options), pointer(targets), pointer(q0), stride, pointer(q), q.shape[1],
        pointer(numbers), len(targets), spread(0.0),
    )  # fmt: skip
