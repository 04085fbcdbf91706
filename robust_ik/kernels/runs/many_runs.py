"""Many runs of one program in compiled code: eight side by side where they can be, else one by one."""

from __future__ import annotations

from robust_ik.checks import Array
from robust_ik.kernels.compiler.compiling import inlined
from robust_ik.kernels.compiler.simd_lanes import COUNT
from robust_ik.kernels.compiler.stack_memory import Pointer, Sizes, further, pointer
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.control_step import control_step
from robust_ik.kernels.control.level_freedom import record_of
from robust_ik.kernels.control.rows.frame_motion import map_of
from robust_ik.kernels.runs.drives import drive, measure
from robust_ik.kernels.runs.eight_runs import eight_runs

TOGETHER = 3
"""Least number of runs that are made side by side. Chosen: eight take about as long as three one by one."""


@inlined
def one_run(
    program: Pointer, desk: Pointer, q: Pointer, asked: Pointer, moving: Pointer, measured: Pointer, done: int,
    steps: int, every: int, noise: float, share: float, seed: int, all_q: Pointer, all_qdot: Pointer, width: Sizes,
) -> tuple[int, int]:  # fmt: skip
    """Makes the steps of a run from `done` on; returns how many are done, and the status of the last.

    Args:
        program: The program.
        desk: The desk, with the velocities of the step before and what its limiters remember.
        q: The configuration, (nq,); it is moved on.
        asked: Filled with the velocities of the last step, (n,).
        moving: The velocities that the drives make, (n,); moved on.
        measured: Filled with what is measured of q at the last step, (nq,).
        done: Number of steps that are done.
        steps: Number of steps in all.
        every: Every how many steps are recorded.
        noise: Standard deviation of what is measured, rad or m.
        share: The share of a change of velocity that drives make in a step, 1 for all of it.
        seed: Of the run's random numbers.
        all_q: The record of configurations, (K, nq).
        all_qdot: The record of velocities, (K, n).
        width: See `control_step`.
    """
    status = slots.DONE
    while done < steps:
        measure(program, q, measured, noise, seed, done)
        status = control_step(program, desk, measured, asked, width)
        if status != slots.DONE:
            break
        done += 1
        drive(program, q, asked, moving, share, done, every, all_q, all_qdot)
    return done, status


@inlined
def goes_side_by_side(program: Pointer) -> bool:
    """Whether runs of this program may go side by side: no rows of bounds, and levels by gain formulas alone."""
    good = program[slots.ROWS] == 0.0 and program[slots.RESOLVER] == slots.WALK
    for level in range(int(program[slots.LEVELS])):
        way = record_of(program, level)[slots.WAY]
        good &= way == slots.IN_FREEDOM or way == slots.DECOUPLED
    return bool(good)


@inlined
def many_runs(
    program: Pointer, desk: Array, room: Array, state: Array, done: Array, steps: int, every: int, noise: float,
    share: float, seeds: Array, places: Array, numbers: Array, all_q: Array, all_qdot: Array, width: Sizes,
) -> None:  # fmt: skip
    """Goes on with many runs, each until it is over or needs a step from outside.

    Args:
        program: A program of this thread alone.
        desk: A desk of this thread alone.
        room: Room for eight desks side by side, at a multiple of 64 bytes.
        state: For each run: q, the velocities asked for last, those of the drives, the speeds of stopped levels, what
            is noted from step to step, and room for what is measured, (N, 2 nq + 2 n + L + NOTED); moved on.
        done: For each run the number of steps that are done, and the status of the last, (N, 2); filled.
        steps: See `one_run`.
        every: The same.
        noise: The same.
        share: The same.
        seeds: (N,).
        places: Places in the program of numbers that differ from run to run, (P,).
        numbers: These numbers, (N, P).
        all_q: (N, K, nq), filled.
        all_qdot: (N, K, n), filled.
        width: See `control_step`.
    """
    n, nq, levels = int(program[slots.JOINTS]), int(program[slots.CONFIGURATION]), int(program[slots.LEVELS])
    calmed, noted = further(pointer(desk), int(program[slots.CALM])), int(program[slots.NOTED])
    last = further(pointer(desk), int(program[slots.LAST]))
    eased, size, begin = further(pointer(desk), int(program[slots.EASED])), state.shape[1], 0
    together = goes_side_by_side(program)
    while begin < len(state):
        count = min(COUNT, len(state) - begin) if together else 1
        for e in range(begin, begin + count):
            if done[e, 0] != done[begin, 0]:
                count = 1
        if count >= TOGETHER and done[begin, 0] < steps:
            eight_runs(
                program, desk, room, state, done, begin, count, steps, every, noise, share, seeds, places, numbers,
                all_q, all_qdot, width,
            )  # fmt: skip
            begin += count
            continue
        for e in range(begin, begin + count):
            if done[e, 0] >= steps:
                continue
            for p in range(len(places)):
                program[int(places[p])] = numbers[e, p]
            q = further(pointer(state), e * size)
            asked, moving = further(q, nq), further(q, nq + n)
            speeds, noticed = further(q, nq + 2 * n), further(q, nq + 2 * n + levels)
            measured = further(noticed, noted)
            for i in range(n):
                last[i] = asked[i] / map_of(program, i)[slots.UNIT]
            for i in range(levels):
                eased[i] = speeds[i]
            for i in range(noted):
                calmed[i] = noticed[i]
            made, status = one_run(
                program, pointer(desk), q, asked, moving, measured, int(done[e, 0]), steps, every, noise, share,
                int(seeds[e]), further(pointer(all_q), e * all_q.shape[1] * nq),
                further(pointer(all_qdot), e * all_q.shape[1] * n), width,
            )  # fmt: skip
            done[e, 0], done[e, 1] = float(made), float(status)
            for i in range(levels):
                speeds[i] = eased[i]
            for i in range(noted):
                noticed[i] = calmed[i]
        begin += count
