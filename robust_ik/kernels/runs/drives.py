"""What is measured of a run before a step, and what the drives make of the velocities that are asked for."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.level_freedom import VECTOR
from robust_ik.kernels.control.rows.frame_motion import map_of, value_of
from robust_ik.kernels.pose.starts.random_values import random


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
def measure(program: Pointer, q: Pointer, measured: Pointer, noise: float, seed: int, done: int) -> None:
    """Fills in what is measured of q after `done` steps."""
    n, off = int(program[slots.JOINTS]), stack(0.0, ONE, VECTOR)
    if noise > 0.0:
        for i in range(n):
            off[i] = normal(seed, done * n + i)
        move_joints(program, q, off, noise, measured)
    else:
        for i in range(int(program[slots.CONFIGURATION])):
            measured[i] = q[i]


@called
def drive(
    program: Pointer, q: Pointer, asked: Pointer, moving: Pointer, share: float, done: int, every: int, all_q: Pointer,
    all_qdot: Pointer,
) -> None:  # fmt: skip
    """Moves the velocities of the drives and q on, and records the step if it is one that is recorded.

    Args:
        program: The program.
        q: (nq,), moved on.
        asked: The velocities that the controller asks for, (n,).
        moving: Those that the drives make, (n,), moved on.
        share: The share of a change of velocity that drives make in a step.
        done: Number of the step, from 1.
        every: Every how many steps are recorded.
        all_q: The record of configurations, (K, nq).
        all_qdot: The record of velocities asked for, (K, n).
    """
    n, nq = int(program[slots.JOINTS]), int(program[slots.CONFIGURATION])
    for i in range(n):
        moving[i] += share * (asked[i] - moving[i])
    move_joints(program, q, moving, program[slots.DT], q)
    if done % every == 0:
        at = done // every - 1
        for i in range(nq):
            all_q[at * nq + i] = q[i]
        for i in range(n):
            all_qdot[at * n + i] = asked[i]
