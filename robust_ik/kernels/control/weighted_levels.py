"""All levels at once by their weights: the compiled form of `resolvers.weighted_priority`, which has the reasons."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.level_fit import ALL_BUT, PRICE, constrain, costs
from robust_ik.kernels.control.level_freedom import (
    MATRIX,
    VECTOR,
    asked_velocity,
    filtered,
    found_of,
    length_of,
    record_of,
    reduce,
    reduce_to,
    steady,
)
from robust_ik.kernels.control.resolve_levels import missing_of, rest, start_inside
from robust_ik.kernels.control.second_order_motion import is_finite, moved
from robust_ik.kernels.matrices.small_products import dot
from robust_ik.kernels.within_bounds.feasible_start import clip
from robust_ik.kernels.within_bounds.polyhedron_projection import nearest_inside

REGULARISATION = 1e-9
"""As `bounded_qp.REGULARISATION`."""
LEAST = 1e-12
"""As `weighted_priority.LEAST`."""


@called
def weigh_levels(program: Pointer, desk: Pointer, width: Sizes) -> int:
    """Fills QDOT with the velocities that resolve all levels at once; a status.

    Starts with more rows below their floors than there is room for are UNCERTAIN: NumPy makes such a step.

    Args:
        program: See `control_layout`.
        desk: The same.
        width: At least the number of joints, and of rows of every level.
    """
    n, levels, qdot = int(program[slots.JOINTS]), int(program[slots.LEVELS]), further(desk, int(program[slots.QDOT]))
    lower, upper = further(desk, int(program[slots.LOWER])), further(desk, int(program[slots.UPPER]))
    free, metric, share = stack(0.0, ONE, VECTOR), stack(0.0, ONE, MATRIX), 1.0
    rest(n, free)
    if not start_inside(program, desk, lower, upper, free, float(slots.FIRST_STAGE)):
        return slots.UNCERTAIN
    wish(program, desk, free, metric, width)
    inside = contains(program, desk, lower, upper, free)
    if inside:
        for c in range(n):
            qdot[c] = free[c]
    else:
        nearest_by(program, desk, lower, upper, metric, free, qdot)
    for level in range(levels):
        record = record_of(program, level)
        if not inside:
            share = share_given(further(desk, int(record[slots.JACOBIAN])), int(record[slots.M]), n, free, qdot)
        found_of(program, desk, level)[slots.SHARE] = share
        missing_of(program, desk, level, 1.0, qdot, further(desk, int(record[slots.RESIDUAL])))
    return slots.DONE if is_finite(program, desk) else slots.TOO_LARGE


@called
def wish(program: Pointer, desk: Pointer, free: Pointer, metric: Pointer, width: Sizes) -> None:
    """Fills in the velocities without bounds, and the cost of others; each level's numbers are those in its freedom."""
    n, levels = int(program[slots.JOINTS]), int(program[slots.LEVELS])
    R, x, motion = stack(0.0, ONE, MATRIX), stack(0.0, ONE, VECTOR), further(desk, int(program[slots.MOTION]))
    total, floor, size, wanted = 0.0, 0.0, stack(0.0, ONE, ONE), stack(0.0, ONE, VECTOR)
    for level in range(levels):
        record = record_of(program, level)
        J = further(desk, int(record[slots.JACOBIAN]))
        total += record[slots.LEVEL_WEIGHT] * dot(J, J, int(record[slots.M]) * n)
    root = math.sqrt(REGULARISATION * max(total, LEAST))
    for r in range(n):
        x[r] = 0.0
        for c in range(n):
            metric[r * n + c] = 0.0
            R[r * n + c] = root if r == c else 0.0
    for level in range(levels):
        record, found = record_of(program, level), found_of(program, desk, level)
        reduce_to(program, desk, level, n, width)
        U, s = further(desk, int(record[slots.LEFT])), further(desk, int(record[slots.SIGMA]))
        Vt, own = further(desk, int(record[slots.RIGHT])), further(desk, int(record[slots.OWN]))
        asked_velocity(program, desk, level, wanted)
        for c in range(n):
            motion[c] = 0.0
        if record[slots.WAY] >= slots.CURVED:
            moved(program, desk, level, wanted, level >= 0, width)
        elif found[slots.RANK] > 0.0:
            filtered(program, record, U, s, Vt, int(found[slots.COUNT]), own, wanted, motion)
        size[0] = length_of(wanted, int(record[slots.M]))
        if program[slots.STEADY] > 0.0:
            steady(program, desk, level, wanted, size)
        weight = record[slots.LEVEL_WEIGHT]
        add_rows(further(desk, int(record[slots.JACOBIAN])), int(record[slots.M]), n, math.sqrt(weight), motion, R, x)
        floor = max(floor, add_cost(program, desk, level, weight, program[slots.DT] * size[0], metric))
        if level > 0:
            reduce(program, desk, level, width)
    for c in range(n):
        metric[c * n + c] += floor if floor > 0.0 else 1.0
    for r in range(n - 1, -1, -1):
        free[r] = x[r]
        for c in range(r + 1, n):
            free[r] -= R[r * n + c] * free[c]
        free[r] /= R[r * n + r]


@called
def add_rows(J: Pointer, m: int, n: int, root: float, motion: Pointer, R: Pointer, x: Pointer) -> None:
    """Rotates the rows root · J, which want root · J · motion, into the triangle R and what it wants."""
    row = stack(0.0, ONE, VECTOR)
    for r in range(m):
        wanted = root * dot(further(J, r * n), motion, n)
        for c in range(n):
            row[c] = root * J[r * n + c]
        for k in range(n):
            if row[k] != 0.0:
                size = math.hypot(R[k * n + k], row[k])
                cosine, sine = R[k * n + k] / size, row[k] / size
                for c in range(k, n):
                    above, below = R[k * n + c], row[c]
                    R[k * n + c], row[c] = cosine * above + sine * below, cosine * below - sine * above
                x[k], wanted = cosine * x[k] + sine * wanted, cosine * wanted - sine * x[k]


@called
def add_cost(program: Pointer, desk: Pointer, level: int, weight: float, stride: float, metric: Pointer) -> float:
    """Adds the cost of motions that move a level, in the freedom of all joints; returns that of the others."""
    record, n = record_of(program, level), int(program[slots.JOINTS])
    roots, own = stack(0.0, ONE, VECTOR), further(desk, int(record[slots.OWN]))
    Vt, rank, size = further(desk, int(record[slots.RIGHT])), costs(program, desk, level, stride, roots), 0.0
    size = weight * own[0] * own[0]
    for i in range(rank):
        cost = size * (roots[i] * roots[i])
        for r in range(n):
            for c in range(n):
                metric[r * n + c] += cost * Vt[i * n + r] * Vt[i * n + c]
    return float(size * (roots[rank] * roots[rank] if rank < n else PRICE))


@called
def contains(program: Pointer, desk: Pointer, lower: Pointer, upper: Pointer, qdot: Pointer) -> bool:
    """Whether velocities are inside the bounds."""
    n, inside = int(program[slots.JOINTS]), True
    rows, floor = further(desk, int(program[slots.BOUND_ROWS])), further(desk, int(program[slots.FLOOR]))
    for c in range(n):
        inside &= lower[c] <= qdot[c] <= upper[c]
    for r in range(int(program[slots.ROWS])):
        inside &= dot(further(rows, r * n), qdot, n) >= floor[r]
    return inside


@called
def nearest_by(
    program: Pointer, desk: Pointer, lower: Pointer, upper: Pointer, metric: Pointer, free: Pointer, qdot: Pointer
) -> None:
    """Moves velocities inside the bounds to those nearest to `free` in the metric, which is overwritten."""
    n, rows = int(program[slots.JOINTS]), int(program[slots.ROWS])
    wanted, y, kept = stack(0.0, ONE, VECTOR), stack(0.0, ONE, VECTOR), stack(0.0, ONE, MATRIX)
    directions = further(desk, int(program[slots.SCRATCH]))
    room = further(directions, (n + 1 + rows) * (n + 1))
    factor(metric, n)
    for r in range(n):
        wanted[r] = 0.0
        for c in range(r, n):
            wanted[r] += metric[r * n + c] * (free[c] - qdot[c])
    for k in range(n):  # column k of the inverse of the triangle
        for r in range(n - 1, -1, -1):
            total = 1.0 if r == k else 0.0
            for c in range(r + 1, n):
                total -= metric[r * n + c] * kept[c * n + k]
            kept[r * n + k] = total / metric[r * n + r]
    for i in range(n * n):
        directions[i] = kept[i]
    constrain(program, desk, lower, upper, qdot, directions, n, 0, room)
    nearest_inside(directions, room, n, rows, n, wanted, y)
    for c in range(n):
        qdot[c] = clip(qdot[c] + dot(further(kept, c * n), y, n), lower[c], upper[c])


@called
def factor(metric: Pointer, n: int) -> None:
    """Replaces a positive definite matrix by the upper triangle R with RᵀR equal to it, scaled to entries of size 1."""
    largest = 0.0
    for i in range(n * n):
        largest = max(largest, abs(metric[i]))
    for i in range(n * n):
        metric[i] /= largest
    for r in range(n):
        for c in range(r, n):
            total = metric[r * n + c]
            for k in range(r):
                total -= metric[k * n + r] * metric[k * n + c]
            metric[r * n + c] = math.sqrt(total) if c == r else total / metric[r * n + r]


@called
def share_given(J: Pointer, m: int, n: int, free: Pointer, qdot: Pointer) -> float:
    """The share of what `free` gives a level that q̇ gives it; see `bounded_qp.share_of`."""
    largest, size, share = 0.0, 0.0, 0.0
    for r in range(m):
        largest = max(largest, abs(dot(further(J, r * n), free, n)))
    if largest == 0.0:
        return 1.0
    for r in range(m):
        row = further(J, r * n)
        wanted = dot(row, free, n) / largest
        size, share = size + wanted * wanted, share + wanted * (dot(row, qdot, n) / largest)
    share = max(0.0, min(1.0, share / size))
    return 1.0 if share > ALL_BUT else share
