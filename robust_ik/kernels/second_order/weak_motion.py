"""The compiled form of `inverses.second_order.weak_motion.weak_motion`: the kernel motion with the least f."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, sizes, stack
from robust_ik.kernels.matrices.small_products import dot
from robust_ik.kernels.matrices.symmetric_eigenvectors import diagonalise
from robust_ik.kernels.second_order import second_order_layout as lay
from robust_ik.kernels.second_order.quartic import damped_start, descend, second_derivative
from robust_ik.kernels.second_order.weak_rows import (
    largest_of,
    matrix_of,
    motion_of,
    norm,
    upright,
    vector_of,
)

FOUR = sizes(4)
"""Most starts of the descent."""


@called
def chosen_side(before: float, start: float, motion: Pointer, n: int, speed: float) -> float:
    """±1: on along the last velocity, else as the first-order motion, else so that the largest joint turns positive."""
    if abs(before) > lay.MOVING * speed:
        return math.copysign(1.0, before)
    if abs(start) > lay.MOVING**2 * speed:
        return math.copysign(1.0, start)
    return upright(motion, n)


@called
def joint_motion(sheet: Pointer, z: Pointer, n: int, motion: Pointer, width: Sizes) -> None:
    """Fills in the joint motion Z z, (n,), of a kernel motion."""
    for c in range(n):
        motion[c] = 0.0
    for a in range(int(sheet[lay.FREE])):
        for c in range(n):
            motion[c] += motion_of(sheet, a, n, width)[c] * z[a]


@called
def starts_of(sheet: Pointer, size: float, before: Pointer, n: int, speed: float, starts: Pointer, width: Sizes) -> int:
    """Fills in the starts of the descent, p numbers each, and returns how many they are.

    Args:
        sheet: With the quartic.
        size: ‖w c‖ of what is asked.
        before: Zᵀ times the last velocities, (p,).
        n: Number of joints.
        speed: Joint speed limit, rad/s.
        starts: Room for four.
        width: At least n.
    """
    p, count = int(sheet[lay.FREE]), 1
    damped_start(sheet, starts, width)
    shorter = min(1.0, lay.FARTHEST * speed / max(norm(starts, p), lay.TINY))
    for a in range(p):
        starts[a] *= shorter
    values, vectors, motion = stack(0.0, ONE, width), stack(0.0, width, width), stack(0.0, ONE, width)
    A, lowest = stack(0.0, width, width), 0
    second_derivative(sheet, matrix_of(sheet, lay.SLOPE, width), vector_of(sheet, lay.WANTED, width), A, width)
    diagonalise(A, p, values, vectors)
    for i in range(1, p):
        lowest = i if values[i] < values[lowest] else lowest
    if values[lowest] < 0.0:
        d = further(vectors, lowest * p)
        along = dot(before, d, p)
        far = math.sqrt(2.0 * size / (max(sheet[lay.CURVATURE], lay.STIFF) * sheet[lay.LOOK_AHEAD]))
        far = min(far, lay.FARTHEST * speed)
        joint_motion(sheet, d, n, motion, width)
        step = far * chosen_side(along, dot(starts, d, p), motion, n, speed)
        for _ in range(2 if abs(along) <= lay.MOVING * speed else 1):
            for a in range(p):
                starts[count * p + a] = step * d[a]
            step = -step
            count += 1
    if largest_of(before, p) > lay.MOVING * speed:
        for a in range(p):
            starts[count * p + a] = before[a]
        count += 1
    return count


@called
def weak_motion(sheet: Pointer, last: Pointer, n: int, speed: float, z: Pointer, width: Sizes) -> None:
    """Fills in the z, (p,), with the least f; nearly equal minima are told apart by the last velocities, (n,)."""
    k, p = int(sheet[lay.WEAK]), int(sheet[lay.FREE])
    fades, reach = vector_of(sheet, lay.FADES, width), vector_of(sheet, lay.REACH, width)
    before, starts, size = stack(0.0, ONE, width), stack(0.0, FOUR, width), 0.0
    for i in range(k):
        size += (fades[i] * vector_of(sheet, lay.WANTED, width)[i]) ** 2
    size = math.sqrt(size) + lay.TINY
    for a in range(p):
        before[a] = dot(motion_of(sheet, a, n, width), last, n)
    count, least = starts_of(sheet, size, before, n, speed, starts, width), math.inf
    turn = lay.HYSTERESIS * (size / speed) ** 2
    for index in range(count):
        end, apart = further(starts, index * p), 0.0
        price = descend(sheet, end, width)
        for a in range(p):
            apart += (end[a] - before[a]) ** 2
        price += turn * min(1.0, apart) + lay.FIRST_COME * size**2 * index
        if price < least:
            least = price
            for a in range(p):
                z[a] = end[a]
    fastest = 0.0
    for a in range(p):
        fastest += (reach[a] * z[a]) ** 2
    over = max(0.0, 1.0 - lay.FARTHEST * speed / max(math.sqrt(fastest), lay.TINY))
    for a in range(p):
        z[a] *= 1.0 - reach[a] * over
