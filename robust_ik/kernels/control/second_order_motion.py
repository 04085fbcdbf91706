"""A level's motion by the second-order inverse, with its memory: see `inverses.second_order` and `filtered_motion`."""

from __future__ import annotations

import math
from typing import Any

from numba.extending import overload

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.simd_lanes import LANES
from robust_ik.kernels.compiler.stack_memory import ONE, W8, W16, Pointer, Sizes, further, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.level_freedom import (
    BESIDE,
    LARGEST,
    MATRIX,
    VECTOR,
    asked_velocity,
    basis_of,
    found_of,
    project,
    record_of,
)
from robust_ik.kernels.control.rows.jacobian_gradients import add_curvature, projected
from robust_ik.kernels.matrices.small_svd import decompose_some
from robust_ik.kernels.second_order import second_order_layout as lay
from robust_ik.kernels.second_order.second_order_entries import SHEET_8, SHEET_16, SQUARE_8, SQUARE_16
from robust_ik.kernels.second_order.second_order_step import finite_sum, first_order, second_order
from robust_ik.kernels.second_order.turning import forget
from robust_ik.kernels.second_order.weak_rows import fade, largest_of, left_of


def moved(program: Pointer, desk: Pointer, level: int, wanted: Pointer, whole: bool, width: Sizes) -> None:
    """`second_order_motion`, for a single run of at most 16 joints, and rows of levels: others have no such levels."""
    raise NotImplementedError


@overload(moved, strict=False)
def _moved(program: Any, desk: Any, level: Any, wanted: Any, whole: Any, width: Any) -> Any:
    def small(program: Pointer, desk: Pointer, level: int, wanted: Pointer, whole: bool, width: Sizes) -> None:
        second_order_motion(program, desk, level, wanted, whole, SHEET_8, SQUARE_8, width)

    def large(program: Pointer, desk: Pointer, level: int, wanted: Pointer, whole: bool, width: Sizes) -> None:
        second_order_motion(program, desk, level, wanted, whole, SHEET_16, SQUARE_16, width)

    if desk.dtype == LANES or width.count > len(W16):
        return lambda program, desk, level, wanted, whole, width: None
    return small if width.count == len(W8) else large


@called
def curved_motion(program: Pointer, desk: Pointer, level: int, width: Sizes) -> None:
    """Fills MOTION with what the second-order inverse makes of what the level still misses, or asks for."""
    record = record_of(program, level)
    missing = further(desk, int(record[slots.MISSING]))
    whole, wanted = record[slots.WAY] == slots.CURVED_DECOUPLED, stack(missing[0], ONE, VECTOR)
    if whole and level > 0:
        asked_velocity(program, desk, level, wanted)
    else:
        for r in range(int(record[slots.M])):
            wanted[r] = missing[r]
    moved(program, desk, level, wanted, whole, width)
    project(program, desk, level, further(desk, int(program[slots.MOTION])))


@called
def second_order_motion(
    program: Pointer, desk: Pointer, level: int, wanted: Pointer, whole: bool, sheet: Sizes, square: Sizes,
    width: Sizes,
) -> None:  # fmt: skip
    """Fills MOTION with (J N)# wanted, and moves the level's memory on.

    Args:
        program: See `control_layout`.
        desk: The same.
        level: The level.
        wanted: Task velocity, (m,).
        whole: Whether all joint motions are free to it, whatever the levels above have left.
        sheet: Room for a sheet of the second-order inverse, in rows of `width`.
        square: Room for a matrix of `width`.
        width: At least the number of joints, and of rows of the level.
    """
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    m, d, motion = int(record[slots.M]), int(found[slots.FREE]), further(desk, int(program[slots.MOTION]))
    A, x, least = stack(0.0, ONE, MATRIX), stack(0.0, ONE, VECTOR), 0.0
    J, s, own = (
        further(desk, int(record[slots.JACOBIAN])),
        further(desk, int(record[slots.SIGMA])),
        further(desk, int(record[slots.OWN])),
    )
    for c in range(n):
        motion[c] = 0.0
    found[slots.LOW] = 0.0
    if whole or d == n:
        for i in range(m * n):
            A[i] = J[i]
        if largest_of(A, m * n) == 0.0:
            return
    else:
        if found[slots.RANK] == 0.0:
            return
        left_over(program, desk, level, A)
        least = own[0] if s[0] < own[0] * BESIDE else 0.0
    longest = largest_of(wanted, m)
    for r in range(m):
        x[r] = wanted[r] * (LARGEST / longest) if longest > LARGEST else wanted[r]
    parameters, memory = further(program, int(record[slots.PARAMETERS])), further(desk, int(record[slots.MEMORY]))
    if record[slots.BLIND] > 0.0:
        damped_motion(parameters, A, x, m, n, least, motion, width)
    else:
        beside = 1 if least > 0.0 else 0
        recall(memory, m + beside, n + beside, n)
        memory, rows = further(memory, lay.MEMORY_HEAD), stack(0.0, sheet, width)
        if first_order(parameters, memory, A, x, m, n, least, rows, motion, width):
            forms = stack(0.0, square, width)
            for i in range(int(rows[lay.WEAK])):
                u, form = stack(0.0, ONE, VECTOR), further(forms, i * n * n)
                for r in range(m):
                    u[r] = left_of(rows, r, i, width)
                add_curvature(program, desk, level, u, form)
                if not whole and d < n:
                    projected(form, basis_of(program, desk, level), n, d)
            second_order(parameters, memory, forms, x, m, n, rows, motion, width)
    if math.isnan(finite_sum(motion, n)):
        found[slots.LOW] = 1.0
        for c in range(n):
            motion[c] = 0.0


@called
def left_over(program: Pointer, desk: Pointer, level: int, A: Pointer) -> None:
    """Fills in J N of a level, (m, n), with zeros for its singular values that are none."""
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    m, count, s = int(record[slots.M]), int(found[slots.COUNT]), further(desk, int(record[slots.SIGMA]))
    U, Vt = further(desk, int(record[slots.LEFT])), further(desk, int(record[slots.RIGHT]))
    for r in range(m):
        for c in range(n):
            total = 0.0
            for i in range(count):
                total += U[r * count + i] * s[i] * Vt[i * n + c]
            A[r * n + c] = total


@called
def recall(memory: Pointer, rows: int, joints: int, n: int) -> None:
    """Makes a memory one of an equation of this shape: of another shape the turn is forgotten, as by `SecondOrder`.

    Args:
        memory: See `second_order_layout.MEMORY_ROWS`.
        rows: Rows of the equation, one more than the level if a singular value stands beside those of J N.
        joints: Joints of it, the same.
        n: Number of joints.
    """
    if int(memory[lay.MEMORY_ROWS]) == rows and int(memory[lay.MEMORY_JOINTS]) == joints:
        return
    told = further(memory, lay.MEMORY_HEAD)
    forget(told)
    for c in range(n):
        if int(memory[lay.MEMORY_JOINTS]) != joints:
            told[lay.LAST + c] = 0.0
    memory[lay.MEMORY_ROWS], memory[lay.MEMORY_JOINTS] = float(rows), float(joints)


@called
def damped_motion(
    parameters: Pointer, A: Pointer, x: Pointer, m: int, n: int, least: float, motion: Pointer, width: Sizes
) -> None:
    """Fills in the motion without curvature: see `SecondOrder.solve`.

    Args:
        parameters: See `second_order_layout`.
        A: J N, (m, n), not zero.
        x: Task velocity, (m,).
        m: Number of rows.
        n: Number of joints.
        least: Least σ₁ to compare with.
        motion: (n,), filled.
        width: At least m and n.
    """
    k, size = min(m, n), 0.0
    U, s, Vt, c = stack(0.0, ONE, MATRIX), stack(0.0, ONE, VECTOR), stack(0.0, ONE, MATRIX), stack(0.0, ONE, VECTOR)
    decompose_some(A, U, s, Vt, m, n, k, 1, width, width, 0.0)
    largest = max(s[0], least)
    for i in range(k):
        c[i] = 0.0
        for r in range(m):
            c[i] += U[r * k + i] * x[r]
        s[i], c[i] = s[i] / largest, c[i] / largest
        size += (fade(s[i] / parameters[lay.GAMMA]) * c[i]) ** 2
    damping = lay.FLOOR**2 + size / (2.0 * parameters[lay.SPEED]) ** 2
    for j in range(n):
        motion[j] = 0.0
    for i in range(k):
        squared = s[i] * s[i] + fade(s[i] / parameters[lay.GAMMA]) * damping
        share = s[i] / squared * c[i] if squared > 0.0 else 0.0
        for j in range(n):
            motion[j] += share * Vt[i * n + j]


@called
def is_finite(program: Pointer, desk: Pointer) -> bool:
    """Whether the motions of all levels of second order were numbers."""
    good = True
    for level in range(int(program[slots.LEVELS])):
        curved = record_of(program, level)[slots.WAY] >= slots.CURVED
        good &= not (curved and found_of(program, desk, level)[slots.LOW] > 0.0)
    return good
