"""Follows a curve of solutions of a closed loop: one joint leads, the others are corrected by Newton's method.

The joint that leads is the one that complete pivots leave over, so that turning points are no obstacle.
Source: Allgower and Georg 1990, Numerical Continuation Methods, chapter 2, with pivots in place of a normal plane.
"""

from __future__ import annotations

import math

from robust_ik.checks import Array
from robust_ik.kernels.branches.loop_state import SIX, change, loop_state
from robust_ik.kernels.compiler.compiling import FLOAT, WHOLE, called, filled, given, kernel
from robust_ik.kernels.compiler.stack_memory import ONE, W16, Pointer, pointer, stack

CORRECTIONS = 8
"""Most Newton steps for a point."""
ON_CURVE, NEARLY = 1e-12, 1e-10
"""Errors at which a point is on the curve, and up to which it is taken."""
SMALLEST = 1e-12
"""A pivot that gives no motion."""
FIRST_STEP, SHORTEST, LONGEST = 0.05, 1e-3, 0.1
"""Lengths of steps, rad and units of length."""
AT_LIMIT = 1e-9
"""By how much a joint may pass its limit, rad or units of length."""
BEND = math.cos(0.3)
"""Cosine of the largest angle between two steps."""


@called
def eliminated(J: Pointer, rows: int, k: int, rank: int, twist: Pointer, columns: Pointer) -> float:
    """Eliminates `rank` rows of J, (rows, k), with the twist, by complete pivots; the last pivot over the first one."""
    for j in range(k):
        columns[j] = float(j)
    first, last = 0.0, 0.0
    for r in range(rank):
        row, column, largest = r, r, -1.0
        for i in range(r, rows):
            for j in range(r, k):
                if abs(J[k * i + j]) > largest:
                    row, column, largest = i, j, abs(J[k * i + j])
        if r == 0:
            first = largest
        last = largest
        if not largest > SMALLEST:
            return 0.0
        if row != r:
            for j in range(k):
                J[k * r + j], J[k * row + j] = J[k * row + j], J[k * r + j]
            twist[r], twist[row] = twist[row], twist[r]
        if column != r:
            for i in range(rows):
                J[k * i + r], J[k * i + column] = J[k * i + column], J[k * i + r]
            columns[r], columns[column] = columns[column], columns[r]
        for i in range(r + 1, rows):
            factor = J[k * i + r] / J[k * r + r]
            for j in range(r, k):
                J[k * i + j] -= factor * J[k * r + j]
            twist[i] -= factor * twist[r]
    return last / first


@called
def solved(J: Pointer, k: int, rank: int, right: Pointer, columns: Pointer, to: Pointer) -> None:
    """Fills in the joint motion whose pivot joints serve `right`, (rank,); the others stay."""
    for j in range(k):
        to[j] = 0.0
    for r in range(rank - 1, -1, -1):
        total = right[r]
        for j in range(r + 1, rank):
            total -= J[k * r + j] * to[int(columns[j])]
        to[int(columns[r])] = total / J[k * r + r]


@called
def tangent(J: Pointer, k: int, rank: int, columns: Pointer, to: Pointer) -> None:
    """Fills in the unit motion that J, eliminated, does not see, (k,)."""
    right, lead, size = stack(0.0, ONE, W16), int(columns[rank]), 0.0
    for r in range(rank):
        right[r] = -J[k * r + rank]
    solved(J, k, rank, right, columns, to)
    to[lead] = 1.0
    for j in range(k):
        size += to[j] * to[j]
    size = math.sqrt(size)
    for j in range(k):
        to[j] /= size


@called
def follow(
    axes: Pointer, slides: Pointer, k: int, g: Pointer, p: Pointer, rows: int, rank: int, own: int, limits: Pointer,
    start: Pointer, sign: float, most: int, out: Pointer,
) -> tuple[int, bool]:  # fmt: skip
    """Fills in points of the curve after its start; how many, and whether it comes back to the start.

    Args:
        axes: See `loop_state`, as slides to rows.
        slides: The same.
        k: The same.
        g: The same.
        p: The same.
        rows: The same.
        rank: Rank of J along the curve, k − 1.
        own: The first joints, which have limits.
        limits: Lower and upper ones, (2, own).
        start: A point on the curve, (k,).
        sign: 1 or −1 for the direction.
        most: Room for points.
        out: Filled, (most, k).
    """
    J, twist, columns = stack(0.0, SIX, W16), stack(0.0, ONE, W16), stack(0.0, ONE, W16)
    at, along, there, step = stack(0.0, ONE, W16), stack(0.0, ONE, W16), stack(0.0, ONE, W16), stack(0.0, ONE, W16)
    for j in range(k):
        at[j] = start[j]
    loop_state(axes, slides, k, at, g, p, rows, J, twist)
    eliminated(J, rows, k, rank, twist, columns)
    tangent(J, k, rank, columns, along)
    for j in range(k):
        along[j] *= sign
    h, count = FIRST_STEP, 0
    while count < most and h >= SHORTEST:
        for j in range(k):
            there[j] = at[j] + h * along[j]
        error, well = math.inf, True
        for _ in range(CORRECTIONS):
            error = loop_state(axes, slides, k, there, g, p, rows, J, twist)
            if not error < 1.0:
                break
            well = eliminated(J, rows, k, rank, twist, columns) > 0.0
            if error <= ON_CURVE or not well:
                break
            solved(J, k, rank, twist, columns, step)
            for j in range(k):
                there[j] += step[j]
        length, dot = 0.0, 0.0
        for j in range(k):
            step[j] = there[j] - at[j]
            length += step[j] * step[j]
            dot += step[j] * along[j]
        length = math.sqrt(length)
        if not (error <= NEARLY and well and 0.5 * h < length < 2.0 * h and dot >= BEND * length):
            h *= 0.5
            continue
        beyond = False
        for j in range(own):
            beyond = beyond or there[j] < limits[j] - AT_LIMIT or there[j] > limits[own + j] + AT_LIMIT
        if beyond:
            h *= 0.5
            continue
        if count > 2:
            back, ahead = 0.0, 0.0
            for j in range(k):
                d = change(start[j] - at[j], slides[j])
                back += d * d
                ahead += d * along[j]
            if math.sqrt(back) < 1.2 * length and ahead > 0.0:
                return count, True
        for j in range(k):
            out[k * count + j] = there[j]
            at[j] = there[j]
        count += 1
        tangent(J, k, rank, columns, along)
        dot = 0.0
        for j in range(k):
            dot += along[j] * step[j]
        for j in range(k):
            along[j] = math.copysign(1.0, dot) * along[j]
        h = min(1.4 * h, LONGEST)
    return count, False


@kernel(given(2), given(1), given(1), given(1), WHOLE, WHOLE, WHOLE, given(2), given(1), FLOAT, filled(2))
def follow_curve(
    axes: Array, slides: Array, g: Array, p: Array, rows: int, rank: int, own: int, limits: Array, start: Array,
    sign: float, out: Array,
) -> int:  # fmt: skip
    """Fills in points after `start`; how many there are, or −1 minus that number if the curve is closed."""
    count, closed = follow(
        pointer(axes), pointer(slides), axes.shape[0], pointer(g), pointer(p), rows, rank, own, pointer(limits),
        pointer(start), sign, out.shape[0], pointer(out),
    )  # fmt: skip
    return -1 - count if closed else count
