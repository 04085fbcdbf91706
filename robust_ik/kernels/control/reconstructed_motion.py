"""A level's motion that keeps measures above their bounds: the compiled form of `resolvers.task_reconstruction`."""

from __future__ import annotations

import math
from typing import Any

from numba.extending import overload

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.simd_lanes import LANES
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.calming import asked_share
from robust_ik.kernels.control.level_freedom import MATRIX, VECTOR, fill_gains, filtered, found_of, project, record_of
from robust_ik.kernels.control.rows.jacobian_gradients import measure_gradient
from robust_ik.kernels.matrices.small_products import dot

SMALL = 1e-12
"""As `task_reconstruction.SMALL`."""
DEPENDENT = 1e-6
"""As `kinematics.svd.DEPENDENT`."""


def reconstructed(program: Pointer, desk: Pointer, level: int, width: Sizes) -> None:
    """`reconstructed_motion`, for a single run: runs side by side have no such levels."""
    raise NotImplementedError


@overload(reconstructed, strict=False)
def _reconstructed(program: Any, desk: Any, level: Any, width: Any) -> Any:
    def alone(program: Pointer, desk: Pointer, level: int, width: Sizes) -> None:
        reconstructed_motion(program, desk, level, width)

    return (lambda program, desk, level, width: None) if desk.dtype == LANES else alone


@called
def reconstructed_motion(program: Pointer, desk: Pointer, level: int, width: Sizes) -> None:
    """Fills MOTION with the level's motion, see `TaskReconstruction.motion`."""
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    m, count, missing = int(record[slots.M]), int(found[slots.COUNT]), further(desk, int(record[slots.MISSING]))
    s, own = further(desk, int(record[slots.SIGMA])), further(desk, int(record[slots.OWN]))
    U, Vt = further(desk, int(record[slots.LEFT])), further(desk, int(record[slots.RIGHT]))
    motion, wanted = further(desk, int(program[slots.MOTION])), stack(0.0, ONE, VECTOR)
    for r in range(m):
        wanted[r] = missing[r]
    guard(program, desk, level, width)
    if found[slots.LOW] > 0.0:
        reconstruct(program, desk, level, wanted)
    for c in range(n):
        motion[c] = 0.0
    if found[slots.RANK] > 0.0:
        filtered(program, record, U, s, Vt, count, own, wanted, motion)
    if program[slots.COMPENSATED] > 0.0 and level > 0:
        spare(program, desk, level, motion)
    project(program, desk, level, motion)


@called
def guard(program: Pointer, desk: Pointer, level: int, width: Sizes) -> None:
    """Fills in the level's measure, LOW, and its gradient, SLOPE, if the measure is below its bound; else LOW = 0."""
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    s, measure = further(desk, int(record[slots.SIGMA])), 1.0
    for i in range(int(found[slots.COUNT])):
        measure *= s[i]
    found[slots.LOW] = 0.0
    if int(found[slots.RANK]) != int(record[slots.M]) or not 0.0 < measure < record[slots.BOUND]:
        return
    slope, above = further(desk, int(record[slots.SLOPE])), stack(0.0, ONE, VECTOR)
    others = measure_gradient(program, desk, level, above, width)
    if others <= SMALL or not math.isfinite(others):
        return
    measure_gradient(program, desk, level + 1, slope, width)
    for c in range(n):
        slope[c] = (slope[c] - measure * above[c]) / others
    found[slots.LOW] = measure


@called
def removed(measure: float, bound: float) -> float:
    """k(m, m̄): 0 above m̄, 1 below m̄/2; see `task_reconstruction.smooth`."""
    share = min(max((bound - measure) / (bound / 2.0), 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


@called
def reconstruct(program: Pointer, desk: Pointer, level: int, wanted: Pointer) -> None:
    """Changes the velocity that a level wants, eqs. (21)-(22), corrected."""
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    m, count, slope = int(record[slots.M]), int(found[slots.COUNT]), further(desk, int(record[slots.SLOPE]))
    U, Vt = further(desk, int(record[slots.LEFT])), further(desk, int(record[slots.RIGHT]))
    effect, gains, size, rate, drift = stack(0.0, ONE, VECTOR), stack(0.0, ONE, VECTOR), 0.0, 0.0, 0.0
    s, own = further(desk, int(record[slots.SIGMA])), further(desk, int(record[slots.OWN]))
    fill_gains(program, record, s, count, own, gains)
    for r in range(m):
        effect[r] = 0.0
    for i in range(count):
        along = gains[i] * dot(further(Vt, i * n), slope, n)
        for r in range(m):
            effect[r] += U[r * count + i] * along
    for r in range(m):
        size += effect[r] * effect[r]
    size = math.sqrt(size)
    if size <= SMALL:
        return
    if program[slots.COMPENSATED] > 0.0:
        drift = dot(slope, further(desk, int(program[slots.QDOT])), n)
    for r in range(m):
        rate += effect[r] / size * wanted[r]
    falling = min(rate + drift / size, 0.0) * removed(found[slots.LOW], record[slots.BOUND])
    rising = asked_share(program, desk) * program[slots.WAY_BACK]
    rising *= removed(found[slots.LOW], record[slots.BOUND] / 2.0)
    for r in range(m):
        wanted[r] += (rising - falling) * (effect[r] / size)


@called
def spare(program: Pointer, desk: Pointer, level: int, motion: Pointer) -> None:
    """Takes from a motion what lowers measures of levels above; the level's own measure is unchanged."""
    n, qdot = int(program[slots.JOINTS]), further(desk, int(program[slots.QDOT]))
    rows, values, count = stack(0.0, ONE, MATRIX), stack(0.0, ONE, VECTOR), 0
    for index in range(level):
        low, slope = (
            found_of(program, desk, index)[slots.LOW],
            further(desk, int(record_of(program, index)[slots.SLOPE])),
        )
        if low > 0.0:
            before = dot(slope, qdot, n)
            fall = min(before + dot(slope, motion, n), 0.0) - min(before, 0.0)
            if fall < 0.0:
                values[count] = -fall * removed(low, record_of(program, index)[slots.BOUND])
                free_part(program, desk, level, slope, further(rows, count * n))
                count += 1
    if count == 0:
        return
    if found_of(program, desk, level)[slots.LOW] > 0.0:
        values[count] = 0.0
        slope = further(desk, int(record_of(program, level)[slots.SLOPE]))
        free_part(program, desk, level, slope, further(rows, count * n))
        if add_least(rows, values, count + 1, n, motion):
            return
    add_least(rows, values, count, n, motion)


@called
def free_part(program: Pointer, desk: Pointer, level: int, slope: Pointer, row: Pointer) -> None:
    """Fills in the part of a gradient in the freedom of a level."""
    for c in range(int(program[slots.JOINTS])):
        row[c] = slope[c]
    project(program, desk, level, row)


@called
def add_least(rows: Pointer, values: Pointer, count: int, n: int, motion: Pointer) -> bool:
    """Adds the shortest motion y with rows y = values; False, without it, if rows are short or depend on each other."""
    Q, y = stack(0.0, ONE, MATRIX), stack(0.0, ONE, VECTOR)
    if count > n:
        return False
    for r in range(count):
        row, new = further(rows, r * n), further(Q, r * n)
        size, value = math.sqrt(dot(row, row, n)), values[r]
        if size <= SMALL:
            return False
        for c in range(n):
            new[c] = row[c] / size
        value /= size
        for _ in range(2):  # twice is enough, Kahan
            for i in range(r):
                basis = further(Q, i * n)
                share = dot(basis, new, n)
                for c in range(n):
                    new[c] -= share * basis[c]
                value -= share * y[i]
        rest = math.sqrt(dot(new, new, n))
        if rest < DEPENDENT:
            return False
        for c in range(n):
            new[c] /= rest
        y[r] = value / rest
    for r in range(count):
        for c in range(n):
            motion[c] += y[r] * Q[r * n + c]
    return True
