"""The point of a polyhedron nearest to a given one: the primal active-set method of `within_bounds.active_set`.

Programs whose Hessian is diagonal are brought to this form by scaling their unknowns.
"""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, further, sizes, stack
from robust_ik.kernels.matrices.small_products import dot
from robust_ik.kernels.within_bounds.bounds_layout import UNKNOWNS

ROOM = sizes(UNKNOWNS)
"""Room for the unknowns."""
SAME = 1e-10
"""Unit rows with a smaller slope than this along a unit step do not stop it; as in `active_set`."""
ROUNDING = 1e-11
"""Multipliers below this fraction of the gradient count as zero; as in `active_set`."""
SHORT = 1e-12
"""Rows shorter than this fraction of the longest are rounding, and stop nothing; as in `active_set`."""
VANISHED = 1e-13
"""A step whose free part is shorter than this fraction of it has no free part, but rounding: in any direction."""
ROUNDS = 3
"""Most changes of the active set, per row and unknown; as in `active_set`."""


@called
def append(Q: Pointer, R: Pointer, held: int, row: Pointer, sign: float, d: int) -> None:
    """Adds a row to an orthonormal basis of the held rows: row = Σ Rᵢ Qᵢ."""
    width = len(ROOM)
    new = further(Q, held * width)
    for c in range(d):
        new[c] = sign * row[c]
    for i in range(held):
        R[i * width + held] = 0.0
    for _ in range(2):  # twice is enough, Kahan
        for i in range(held):
            basis = further(Q, i * width)
            share = dot(basis, new, d)
            R[i * width + held] += share
            for c in range(d):
                new[c] -= share * basis[c]
    size = math.sqrt(dot(new, new, d))
    R[held * width + held] = size
    for c in range(d):
        new[c] = new[c] / size if size > 0.0 else 0.0


@called
def nearest_inside(
    normals: Pointer, room: Pointer, pairs: int, singles: int, d: int, wanted: Pointer, y: Pointer
) -> None:
    """Fills y with the point nearest to `wanted` for which normals y ≤ room.

    Args:
        normals: Rows of length d: `pairs` of them bound y from both sides, then `singles` from one side. They are
            brought to unit length.
        room: For each pair the room along its normal, then for each pair the room against it, then for each single row;
            ≥ 0, possibly infinite: y = 0 is inside.
        pairs: Number of rows with two sides.
        singles: Number of rows with one side.
        d: Number of unknowns.
        wanted: (d,).
        y: (d,), filled.
    """
    width, rows = len(ROOM), pairs + singles
    Q, R = stack(0.0, ROOM, ROOM), stack(0.0, ROOM, ROOM)
    step, pull, at = stack(0.0, ONE, ROOM), stack(0.0, ONE, ROOM), stack(0.0, ONE, ROOM)
    longest = 0.0
    for c in range(d):
        y[c] = 0.0
    for r in range(rows):
        row = further(normals, r * d)
        longest = max(longest, dot(row, row, d))
    longest = math.sqrt(longest)
    for r in range(rows):
        row = further(normals, r * d)
        size = math.sqrt(dot(row, row, d))
        if size > SHORT * longest:
            for c in range(d):
                row[c] /= size
            room[r if r < pairs else r + pairs] /= size
            if r < pairs:
                room[r + pairs] /= size
        else:
            for c in range(d):
                row[c] = 0.0
    held = 0
    for _ in range(ROUNDS * (pairs + rows + d)):
        for c in range(d):
            step[c] = wanted[c] - y[c]
        whole = math.sqrt(dot(step, step, d))
        for _ in range(2 if held > 0 else 0):
            for i in range(held):
                basis = further(Q, i * width)
                share = dot(basis, step, d)
                for c in range(d):
                    step[c] -= share * basis[c]
        size = math.sqrt(dot(step, step, d))
        best, stop = 1.0 if size > VANISHED * whole else 0.0, -1
        if held < d and best > 0.0:
            for r in range(rows):
                row = further(normals, r * d)
                slope, reached = dot(row, step, d), dot(row, y, d)
                for side in range(2 if r < pairs else 1):
                    index = r if r < pairs and side == 0 else r + pairs
                    if side == 1:
                        slope, reached = -slope, -reached
                    left = room[index] - reached
                    if slope > max(left, SAME * size) and not is_held(at, held, index):
                        share = max(left, 0.0) / slope
                        if stop < 0 or share < best:
                            best, stop = share, index
        for c in range(d):
            y[c] += best * step[c]
        if stop >= 0:
            append_bound(Q, R, held, normals, stop, pairs, d)
            at[held] = float(stop)
            held += 1
            continue
        largest = 0.0
        for c in range(d):
            largest = max(largest, abs(y[c] - wanted[c]))
            step[c] = y[c] - wanted[c]
        for i in range(held):
            pull[i] = -dot(further(Q, i * width), step, d)
        least, worst = 0.0, -1
        for i in range(held - 1, -1, -1):
            for k in range(i + 1, held):
                pull[i] -= R[i * width + k] * pull[k]
            pull[i] /= R[i * width + i]
        for i in range(held):
            if pull[i] < least:
                least, worst = pull[i], i
        if worst < 0 or least >= -ROUNDING * largest:
            break
        for i in range(worst, held - 1):
            at[i] = at[i + 1]
        held -= 1
        for i in range(worst, held):
            append_bound(Q, R, i, normals, int(at[i]), pairs, d)


@called
def is_held(at: Pointer, held: int, index: int) -> bool:
    """Whether a bound is among the held ones."""
    found = False
    for i in range(held):
        found |= int(at[i]) == index
    return found


@called
def append_bound(Q: Pointer, R: Pointer, held: int, normals: Pointer, index: int, pairs: int, d: int) -> None:
    """Appends the normal of a bound, from the side of which it bounds."""
    against = pairs <= index < 2 * pairs
    row = index - pairs if index >= pairs else index
    append(Q, R, held, further(normals, row * d), -1.0 if against else 1.0, d)
