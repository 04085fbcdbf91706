"""The walk down the levels for eight runs side by side, with the bits of `resolve_levels`.

A desk of lanes has the layout of a desk, with eight numbers for each: what is the same for every run is done on it for
all at once. What depends on a run's own numbers, such as a motion that does not fit into the bounds, is done on a desk
of single numbers, to which the run's lane is copied.
"""

from __future__ import annotations

from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.simd_lanes import COUNT, spread
from robust_ik.kernels.compiler.stack_memory import ONE, W8, Pointer, Sizes, each_lane, further, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.level_fit import fit, slowed
from robust_ik.kernels.control.level_freedom import VECTOR, found_of, record_of
from robust_ik.kernels.control.resolve_levels import begin, hurry, move_on, resolve, wish
from robust_ik.kernels.matrices.svd_side_by_side import from_lane, into_lane


@called
def take(room: Pointer, lane: int, at: int, count: int, desk: Pointer) -> None:
    """Copies numbers of a lane to the same places of a desk."""
    from_lane(each_lane(further(room, at)), lane, count, further(desk, at))


@called
def put(desk: Pointer, at: int, count: int, room: Pointer, lane: int) -> None:
    """Copies numbers of a desk to the same places of a lane."""
    into_lane(further(desk, at), count, each_lane(further(room, at)), lane)


@called
def fit_eight(
    program: Pointer, room: Pointer, desk: Pointer, level: int, length: Pointer, change: Pointer, apart: Pointer
) -> None:
    """Fills in the changes that a level gets, and their shares: at once where the wish fits, else lane by lane."""
    record, n = record_of(program, level), int(program[slots.JOINTS])
    lower, upper, qdot = int(program[slots.LONG_LOWER]), int(program[slots.LONG_UPPER]), int(program[slots.QDOT])
    motion, found, k = int(program[slots.MOTION]), int(record[slots.FOUND]), min(n, int(record[slots.M]))
    one_change = stack(0.0, ONE, VECTOR)
    shares = further(room, found + slots.SHARE)
    shares[0] = slowed(
        program, room, further(room, lower), further(room, upper), further(room, qdot), further(room, motion), change
    )
    for lane in range(COUNT):
        if each_lane(shares)[lane] != 1.0 and apart[lane] == 0.0:
            for at in (lower, upper, qdot, motion):
                take(room, lane, at, n, desk)
            take(room, lane, int(record[slots.SIGMA]), k, desk)
            take(room, lane, int(record[slots.OWN]), k, desk)
            take(room, lane, int(record[slots.RIGHT]), n * n, desk)
            take(room, lane, found, slots.NUMBERS, desk)
            each_lane(shares)[lane] = fit(
                program, desk, level, further(desk, lower), further(desk, upper), further(desk, qdot),
                program[slots.DT] * each_lane(length)[lane], further(desk, motion), one_change,
            )  # fmt: skip
            into_lane(one_change, n, each_lane(change), lane)


@called
def most_common(numbers: Pointer, apart: Pointer) -> float:
    """The number that most lanes have, of those that are not apart."""
    best, most = 0.0, 0
    for lane in range(COUNT):
        count = 0
        for other in range(COUNT):
            count += numbers[other] == numbers[lane] and apart[other] == 0.0
        if count > most and apart[lane] == 0.0:
            best, most = numbers[lane], count
    return best


@inlined
def part(
    program: Pointer, room: Pointer, desk: Pointer, size: int, level: int, apart: Pointer, status: Pointer,
    ends: Pointer, width: Sizes,
) -> None:  # fmt: skip
    """Resolves the levels below for lanes that leave another freedom to them than most lanes do, by themselves."""
    closed = further(found_of(program, room, level), slots.CLOSED)
    common, n = most_common(each_lane(closed), apart), int(program[slots.JOINTS])
    for lane in range(COUNT):
        if apart[lane] == 0.0 and each_lane(closed)[lane] != common:
            take(room, lane, 0, size, desk)
            status[lane] = float(resolve(program, desk, level + 1, level < 0, width))
            keep(program, desk, further(ends, lane * 2 * len(VECTOR)), n)
            apart[lane] = 1.0
    closed[0] = spread(common)


@called
def keep(program: Pointer, desk: Pointer, end: Pointer, n: int) -> None:
    """Keeps what a walk has left on a desk: velocities, and the speeds of stopped levels."""
    qdot, eased = further(desk, int(program[slots.QDOT])), further(desk, int(program[slots.EASED]))
    for i in range(n):
        end[i] = qdot[i]
    for i in range(int(program[slots.LEVELS])):
        end[n + i] = eased[i]


@inlined
def resolve_eight(
    program: Pointer, room: Pointer, desk: Pointer, size: int, status: Pointer, ends: Pointer, width: Sizes
) -> None:
    """`resolve` for the problems of eight runs.

    Args:
        program: The program.
        room: Their desks, side by side.
        desk: A desk for what is done by one of them alone.
        size: Length of the desk.
        status: Eight numbers, DONE for those that take part; filled.
        ends: Filled for each lane with its velocities, and the speeds of its stopped levels.
        width: See `resolve`.
    """
    n, levels, qdot = int(program[slots.JOINTS]), int(program[slots.LEVELS]), int(program[slots.QDOT])
    apart, change, length = stack(0.0, ONE, W8), stack(spread(0.0), ONE, VECTOR), stack(spread(0.0), ONE, ONE)
    for lane in range(COUNT):
        apart[lane] = 0.0 if status[lane] == slots.DONE else 1.0
    begin(program, room)
    for level in range(levels):
        wish(program, room, level, False, length, width)
        fit_eight(program, room, desk, level, length, change, apart)
        move_on(program, room, level, change)
        if level < levels - 1:
            part(program, room, desk, size, level, apart, status, ends, width)
    for lane in range(COUNT):
        if apart[lane] == 0.0:
            if program[slots.HURRIED] > 0.0:
                take(room, lane, 0, size, desk)
                if not hurry(program, desk):
                    status[lane] = slots.UNCERTAIN
            else:
                take(room, lane, qdot, n, desk)
                take(room, lane, int(program[slots.EASED]), levels, desk)
            keep(program, desk, further(ends, lane * 2 * len(VECTOR)), n)
