"""Eight runs of one program in step with each other."""

from __future__ import annotations

from robust_ik.checks import Array
from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.simd_lanes import COUNT
from robust_ik.kernels.compiler.stack_memory import (
    ONE,
    W8,
    Pointer,
    Sizes,
    by_eights,
    each_lane,
    further,
    pointer,
    sizes,
    stack,
)
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.control_step import finish, pose_problem
from robust_ik.kernels.control.level_freedom import record_of
from robust_ik.kernels.control.rows.frame_motion import map_of
from robust_ik.kernels.matrices.svd_side_by_side import into_lane
from robust_ik.kernels.runs.drives import drive, measure
from robust_ik.kernels.runs.eight_levels import put, resolve_eight, take

ENDS = sizes(64)
"""Room for velocities and the speeds of stopped levels."""


@inlined
def eight_runs(
    program: Pointer, desks: Array, rooms: Array, state: Array, done: Array, begin: int, count: int, steps: int,
    every: int, noise: float, share: float, seeds: Array, places: Array, numbers: Array, all_q: Array, all_qdot: Array,
    width: Sizes,
) -> None:  # fmt: skip
    """Goes on with the runs from `begin` on, at most eight that are equally far; the others see `many_runs`.

    A run that needs a step from outside stops; the rest go on.
    """
    n, nq, levels = int(program[slots.JOINTS]), int(program[slots.CONFIGURATION]), int(program[slots.LEVELS])
    desk, room, width_of_state = pointer(desks), by_eights(pointer(rooms)), state.shape[1]
    eased, last, qdot = int(program[slots.EASED]), int(program[slots.LAST]), int(program[slots.QDOT])
    calmed, noted = int(program[slots.CALM]), int(program[slots.NOTED])
    status, ends = stack(0.0, ONE, W8), stack(0.0, W8, ENDS)
    for lane in range(COUNT):
        put(desk, 0, len(desks), room, lane)
        status[lane] = slots.DONE if lane < count else slots.UNLIKE
        if lane < count:
            asked = further(pointer(state), (begin + lane) * width_of_state + nq)
            for i in range(n):
                desk[last + i] = asked[i] / map_of(program, i)[slots.UNIT]
            put(desk, last, n, room, lane)
            into_lane(further(asked, 2 * n), levels, each_lane(further(room, eased)), lane)
            into_lane(further(asked, 2 * n + levels), 1, each_lane(further(room, calmed)), lane)
    for step in range(int(done[begin, 0]), steps):
        living = 0
        for lane in range(COUNT):
            if status[lane] == slots.DONE:
                e = begin + lane
                for p in range(len(places)):
                    program[int(places[p])] = numbers[e, p]
                q = further(pointer(state), e * width_of_state)
                measured = further(q, nq + 2 * n + levels + noted)
                measure(program, q, measured, noise, int(seeds[e]), step)
                take(room, lane, last, n, desk)
                noticed = further(q, nq + 2 * n + levels)
                for i in range(noted):
                    desk[calmed + i] = noticed[i]
                status[lane] = pose_problem(program, desk, measured, width)
                for i in range(noted):
                    noticed[i] = desk[calmed + i]
                if status[lane] == slots.DONE:
                    put_problem(program, desk, room, lane)
                    living += 1
                done[e, 0], done[e, 1] = float(step), status[lane]
        if living == 0:
            return
        resolve_eight(program, room, desk, len(desks), status, ends, width)
        for lane in range(COUNT):
            if status[lane] == slots.DONE:
                e, end = begin + lane, further(ends, lane * len(ENDS))
                q = further(pointer(state), e * width_of_state)
                asked, moving, speeds = further(q, nq), further(q, nq + n), further(q, nq + 2 * n)
                noticed = further(speeds, levels)
                for i in range(n):
                    desk[qdot + i] = end[i]
                for i in range(noted):
                    desk[calmed + i] = noticed[i]
                status[lane] = finish(program, desk, asked)
                done[e, 1] = status[lane]
                if status[lane] == slots.DONE:
                    done[e, 0] = float(step + 1)
                    for i in range(levels):
                        speeds[i] = end[n + i]
                    into_lane(speeds, levels, each_lane(further(room, eased)), lane)
                    for i in range(noted):
                        noticed[i] = desk[calmed + i]
                    into_lane(noticed, 1, each_lane(further(room, calmed)), lane)
                    put(desk, last, n, room, lane)
                    to = e * all_q.shape[1]
                    drive(
                        program, q, asked, moving, share, step + 1, every, further(pointer(all_q), to * nq),
                        further(pointer(all_qdot), to * n),
                    )  # fmt: skip


@called
def put_problem(program: Pointer, desk: Pointer, room: Pointer, lane: int) -> None:
    """Copies equations and bounds of a step to a lane."""
    n = int(program[slots.JOINTS])
    for level in range(int(program[slots.LEVELS])):
        record = record_of(program, level)
        put(desk, int(record[slots.JACOBIAN]), int(record[slots.M]) * n, room, lane)
        put(desk, int(record[slots.X]), int(record[slots.M]), room, lane)
    for at in (slots.LOWER, slots.UPPER, slots.LONG_LOWER, slots.LONG_UPPER):
        put(desk, int(program[at]), n, room, lane)
