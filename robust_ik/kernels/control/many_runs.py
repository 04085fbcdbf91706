"""Many runs of one program in compiled code: steps, what is measured, and what the drives make of it."""

from __future__ import annotations

import math

from robust_ik.checks import Array
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, pointer, sizes, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.control_step import control_step
from robust_ik.kernels.control.frame_motion import map_of, value_of
from robust_ik.kernels.control.level_freedom import VECTOR
from robust_ik.kernels.pose.random_values import random

LONGEST = sizes(64)
"""Room for a configuration."""


@called
def normal(seed: int, number: int) -> float:
    """A normally distributed random number with this seed and index, by Box and Muller's transform."""
    radius = math.sqrt(-2.0 * math.log(1.0 - random(seed, 2 * number)))
    return radius * math.cos(2.0 * math.pi * random(seed, 2 * number + 1))


@called
def move_joints(program: Pointer, q: Pointer, change: Pointer, factor: float, moved: Pointer) -> None:
    """Fills in q ⊕ factor · change; `moved` may be q itself."""
    for i in range(int(program[slots.JOINTS])):
        joint = map_of(program, i)
        first, value = int(joint[slots.FIRST]), value_of(program, q, i) + factor * change[i]
        if joint[slots.TURNS] > 0.0:
            moved[first], moved[first + 1] = math.cos(value), math.sin(value)
        else:
            moved[first] = value


@called
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
    n, nq, status = int(program[slots.JOINTS]), int(program[slots.CONFIGURATION]), slots.DONE
    off = stack(0.0, ONE, VECTOR)
    while done < steps:
        for i in range(n):
            off[i] = normal(seed, done * n + i) if noise > 0.0 else 0.0
        if noise > 0.0:
            move_joints(program, q, off, noise, measured)
        else:
            for i in range(nq):
                measured[i] = q[i]
        status = control_step(program, desk, measured, asked, width)
        if status != slots.DONE:
            break
        for i in range(n):
            moving[i] += share * (asked[i] - moving[i])
        move_joints(program, q, moving, program[slots.DT], q)
        done += 1
        if done % every == 0:
            at = done // every - 1
            for i in range(nq):
                all_q[at * nq + i] = q[i]
            for i in range(n):
                all_qdot[at * n + i] = asked[i]
    return done, status


@called
def many_runs(
    program: Pointer, desk: Pointer, state: Array, done: Array, steps: int, every: int, noise: float, share: float,
    seeds: Array, places: Array, numbers: Array, all_q: Array, all_qdot: Array, width: Sizes,
) -> None:  # fmt: skip
    """Goes on with many runs, each until it is over or needs a step from outside.

    Args:
        program: A program of this thread alone.
        desk: A desk of this thread alone.
        state: For each run: q, the velocities asked for last, those of the drives, the speeds of stopped levels, and
            room for what is measured, (N, 2 nq + 2 n + L); moved on.
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
    last, eased = further(desk, int(program[slots.LAST])), further(desk, int(program[slots.EASED]))
    size = state.shape[1]
    for e in range(len(state)):
        if done[e, 0] >= steps:
            continue
        for p in range(len(places)):
            program[int(places[p])] = numbers[e, p]
        q = further(pointer(state), e * size)
        asked, moving = further(q, nq), further(q, nq + n)
        speeds, measured = further(q, nq + 2 * n), further(q, nq + 2 * n + levels)
        for i in range(n):
            last[i] = asked[i] / map_of(program, i)[slots.UNIT]
        for i in range(levels):
            eased[i] = speeds[i]
        count, status = one_run(
            program, desk, q, asked, moving, measured, int(done[e, 0]), steps, every, noise, share, int(seeds[e]),
            further(pointer(all_q), e * all_q.shape[1] * nq), further(pointer(all_qdot), e * all_q.shape[1] * n), width,
        )  # fmt: skip
        done[e, 0], done[e, 1] = float(count), float(status)
        for i in range(levels):
            speeds[i] = eased[i]
