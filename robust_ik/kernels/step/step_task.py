"""The task of a control step: J and ẋ in the wanted rows, scaled."""

from __future__ import annotations

import math

from robust_ik.kernels.chain.chain_kinematics import MOST_JOINTS, SIX, TWELVE, place
from robust_ik.kernels.chain.chain_layout import CIRCLING, CONFIGURATION, FOLLOWING, INDEPENDENT, KIND, PLACE, STRIDE
from robust_ik.kernels.chain.chain_layout import HEAD as CHAIN_HEAD
from robust_ik.kernels.chain.chain_layout import JOINTS as COUNT_OF_JOINTS
from robust_ik.kernels.chain.joint_motion import add_columns, joint_twists
from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.simd_lanes import Number
from robust_ik.kernels.compiler.stack_memory import ONE, W8, W16, Pointer, Sizes, each_lane, further, lanes_of, stack
from robust_ik.kernels.step import step_layout as slots
from robust_ik.kernels.step.step_layout import DONE, NOT_FINITE, OFF_CIRCLE

CIRCLE = 2e-6
"""Largest difference of cos² + sin² from 1. Twice `robot.joint_map.UNIT_CIRCLE_TOLERANCE`, since it is squared."""


@inlined
def check(program: Pointer, q: Pointer, twist: Pointer) -> int:
    """A status: DONE if q and twist are finite and every cosine and sine is of length 1."""
    chain = further(program, int(program[slots.CHAIN]))
    total = 0.0
    for i in range(int(chain[CONFIGURATION])):
        total += q[i] * 0.0
    for i in range(int(program[slots.ROWS])):
        total += twist[i] * 0.0
    if math.isnan(total):
        return NOT_FINITE
    for i in range(int(chain[COUNT_OF_JOINTS])):
        at = CHAIN_HEAD + i * STRIDE
        kind = chain[at + KIND]
        if kind == CIRCLING or kind >= FOLLOWING:
            c, s = q[int(chain[at + PLACE])], q[int(chain[at + PLACE]) + 1]
            if abs(c * c + s * s - 1.0) > CIRCLE:
                return OFF_CIRCLE
    return DONE


@inlined
def task(
    program: Pointer, q: Pointer, twist: Pointer, count: int, J: Pointer, x: Pointer, width: Sizes, zero: Number
) -> None:
    """Fills J and ẋ of `count` steps, in the task rows and scaled by the weights: m rows of `width`, and m numbers."""
    P, L, m = len(width), lanes_of(zero), int(program[slots.ROWS])
    chain = further(program, int(program[slots.CHAIN]))
    axes, end = stack(zero, MOST_JOINTS, SIX), stack(zero, ONE, TWELVE)
    place(chain, q, count, axes, end, zero)
    joint_twists(chain, axes, end, axes, int(program[slots.REFERENCE]), zero)
    for i in range(6 * P):
        J[i] = zero
    add_columns(chain, axes, J, P)
    lanes = each_lane(x)
    for lane in range(count):
        for r in range(m):
            lanes[r * L + lane] = twist[lane * m + r]
    choose_rows(program, J, m, width, zero)
    if program[slots.TASK] > 0.0:
        scale_rows(further(program, int(program[slots.TASK])), m, J, P, zero)
        scale_rows(further(program, int(program[slots.TASK])), m, x, 1, zero)
    if program[slots.JOINTS] > 0.0:
        scale_columns(further(program, int(program[slots.JOINTS])), int(chain[INDEPENDENT]), J, m, P, zero)


@inlined
def choose_rows(program: Pointer, J: Pointer, m: int, width: Sizes, zero: Number) -> None:
    """Replaces the six rows of J by the m wanted ones, in the wanted order."""
    P, all_rows, as_they_are = len(width), stack(zero, W8, width), True
    for r in range(m):
        as_they_are &= int(program[slots.ROW + r]) == r
    if as_they_are:
        return
    for x in range(6 * P):
        all_rows[x] = J[x]
    for r in range(m):
        row = int(program[slots.ROW + r])
        for c in range(P):
            J[r * P + c] = all_rows[row * P + c]


@called
def scale_rows(factor: Pointer, m: int, J: Pointer, width: int, zero: Number) -> None:
    """Replaces J, of m rows, by factor · J."""
    room = stack(zero, ONE, W16)
    for c in range(width):
        for i in range(m):
            room[i] = J[i * width + c]
        for r in range(m):
            total = zero
            for i in range(m):
                total = total + factor[r * m + i] * room[i]
            J[r * width + c] = total


@called
def scale_columns(factor: Pointer, n: int, J: Pointer, m: int, width: int, zero: Number) -> None:
    """Replaces J, of n columns and m rows, by J · factor."""
    room = stack(zero, ONE, W16)
    for r in range(m):
        for i in range(n):
            room[i] = J[r * width + i]
        for c in range(n):
            total = zero
            for i in range(n):
                total = total + room[i] * factor[i * n + c]
            J[r * width + c] = total
