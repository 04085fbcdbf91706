"""Fits one level's motion into the bounds: the compiled form of `within_bounds.level_fit` and `limiters`.

These and `motion_cost` have the reasons.
"""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.simd_lanes import Number, where
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, further, sizes, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.level_freedom import MATRIX, VECTOR, found_of, length_of, record_of
from robust_ik.kernels.matrices.small_products import dot
from robust_ik.kernels.within_bounds.polyhedron_projection import nearest_inside

PRICE = 1e-3
"""As `motion_cost.PRICE`."""
SHARE_SCALE = 1e3
"""1/√`level_fit.SHARE_PRICE`: the share's unknown in units in which the program is a projection."""
TURN = 1e-3
"""As `level_fit.TURN`."""
HUGE = 1e50
"""As `level_fit.HUGE`."""
ROUNDING = 1e-12
"""As `bounds.ROUNDING`, and how close to 1 a share counts as 1."""
ALL_BUT = 1 - 1e-6
"""Shares beyond this count as 1, as by `bounded_qp.ALL_BUT`."""
UNKNOWNS = sizes(33)
"""Room for joints and a share."""


@called
def largest_step(
    program: Pointer, desk: Pointer, lower: Pointer, upper: Pointer, qdot: Pointer, change: Pointer
) -> Number:
    """The largest s in [0, 1] for which q̇ + s·change stays inside; q̇ is inside."""
    n, rows = int(program[slots.JOINTS]), int(program[slots.ROWS])
    share = 1.0
    for c in range(n):
        used = abs(change[c])
        room = max(where(change[c] > 0.0, upper[c] - qdot[c], qdot[c] - lower[c]), 0.0) + ROUNDING
        share = where(used > room, min(share, room / used), share)
    normals, floor = further(desk, int(program[slots.BOUND_ROWS])), further(desk, int(program[slots.FLOOR]))
    for r in range(rows):
        row = further(normals, r * n)
        used, room = -dot(row, change, n), max(dot(row, qdot, n) - floor[r], 0.0) + ROUNDING
        share = where(used > room, min(share, room / used), share)
    return share


@called
def slowed(
    program: Pointer, desk: Pointer, lower: Pointer, upper: Pointer, qdot: Pointer, motion: Pointer, change: Pointer
) -> Number:
    """Fills in the motion, slowed as much as the tightest bound requires; returns its share."""
    share = largest_step(program, desk, lower, upper, qdot, motion)
    for c in range(int(program[slots.JOINTS])):
        change[c] = share * motion[c]
    return share


@called
def within_speeds(program: Pointer, desk: Pointer, qdot: Pointer, motion: Pointer, slower: Pointer) -> None:
    """Fills in the motion, slowed as much as speed limits alone require."""
    n, share, speeds = int(program[slots.JOINTS]), 1.0, further(desk, int(program[slots.SPEEDS]))
    for c in range(n if program[slots.HAS_SPEEDS] > 0.0 else 0):
        left = max(speeds[c] - (qdot[c] if motion[c] > 0.0 else -qdot[c]), 0.0) + ROUNDING
        if abs(motion[c]) > left:
            share = min(share, left / abs(motion[c]))
    for c in range(n):
        slower[c] = share * motion[c]


@called
def share_of(program: Pointer, desk: Pointer, level: int, wanted: Pointer, given: Pointer) -> float:
    """The share that a motion gives a level of what a wanted motion gives it, along it, in [0, 1]."""
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    s, Vt = further(desk, int(record[slots.SIGMA])), further(desk, int(record[slots.RIGHT]))
    effect, count, largest = stack(0.0, ONE, VECTOR), int(found[slots.COUNT]), 0.0
    for i in range(count):
        effect[i] = s[i] * dot(further(Vt, i * n), wanted, n)
        largest = max(largest, abs(effect[i]))
    if largest == 0.0:
        return 1.0
    size, share = 0.0, 0.0
    for i in range(count):
        part = effect[i] / largest
        size += part * part
        share += part * (s[i] * dot(further(Vt, i * n), given, n) / largest)
    share = max(0.0, min(1.0, share / size))
    return 1.0 if share > ALL_BUT else share


@called
def costs(program: Pointer, desk: Pointer, level: int, stride: float, roots: Pointer) -> int:
    """Fills in the roots of the costs of the directions of a level's freedom; returns how many move the level."""
    record, found = record_of(program, level), found_of(program, desk, level)
    s, own = further(desk, int(record[slots.SIGMA])), further(desk, int(record[slots.OWN]))
    d, rank, largest = int(found[slots.FREE]), int(found[slots.RANK]), own[0]
    if rank == 0 or largest == 0.0:
        for i in range(d):
            roots[i] = 1.0
        return 0
    floor = min(1.0, PRICE + stride / largest)
    for i in range(d):
        square = (s[i] / largest) ** 2 if i < rank else 0.0
        roots[i] = math.sqrt(max(floor, min(1.0, square)))
    return rank


@called
def constrain(
    program: Pointer, desk: Pointer, lower: Pointer, upper: Pointer, qdot: Pointer, directions: Pointer, d: int,
    spare: int, room: Pointer,
) -> None:  # fmt: skip
    """Completes the rows of a program after its n joint directions, (n, d), and fills in the room of all.

    Args:
        program: The program.
        desk: The desk.
        lower: The box.
        upper: The box.
        qdot: Where the motion begins, (n,).
        directions: The joint directions; the rows of the bounds are appended after `spare` further rows.
        d: Number of unknowns.
        spare: How many rows come between; their room is the caller's.
        room: Filled.
    """
    n, rows = int(program[slots.JOINTS]), int(program[slots.ROWS])
    normals, floor = further(desk, int(program[slots.BOUND_ROWS])), further(desk, int(program[slots.FLOOR]))
    for c in range(n):
        room[c], room[n + c] = max(upper[c] - qdot[c], 0.0), max(qdot[c] - lower[c], 0.0)
    for r in range(rows):
        row, target = further(normals, r * n), further(directions, (n + spare + r) * d)
        for i in range(d):
            target[i] = 0.0
        for c in range(n):
            for i in range(d):
                target[i] -= row[c] * directions[c * d + i]
        room[2 * n + spare + r] = max(dot(row, qdot, n) - floor[r], 0.0)


@called
def nearest(
    program: Pointer, desk: Pointer, level: int, lower: Pointer, upper: Pointer, qdot: Pointer, stride: float,
    motion: Pointer, change: Pointer,
) -> None:  # fmt: skip
    """Fills in the motion inside the bounds that is nearest to a given one, see `level_fit.nearest`."""
    n, rows = int(program[slots.JOINTS]), int(program[slots.ROWS])
    d, Vt = int(found_of(program, desk, level)[slots.FREE]), further(desk, int(record_of(program, level)[slots.RIGHT]))
    roots, wanted, y = stack(0.0, ONE, UNKNOWNS), stack(0.0, ONE, UNKNOWNS), stack(0.0, ONE, UNKNOWNS)
    directions = further(desk, int(program[slots.SCRATCH]))
    room, kept = further(directions, (n + 1 + rows) * (n + 1)), stack(0.0, ONE, MATRIX)
    costs(program, desk, level, stride, roots)
    for i in range(d):
        wanted[i] = roots[i] * dot(further(Vt, i * n), motion, n)
        for c in range(n):
            kept[c * d + i] = Vt[i * n + c] / roots[i]
            directions[c * d + i] = kept[c * d + i]
    constrain(program, desk, lower, upper, qdot, directions, d, 0, room)
    nearest_inside(directions, room, n, rows, d, wanted, y)
    for c in range(n):
        change[c] = dot(further(kept, c * d), y, d)


@called
def keeping_direction(
    program: Pointer, desk: Pointer, level: int, lower: Pointer, upper: Pointer, qdot: Pointer, stride: float,
    wish: Pointer, change: Pointer,
) -> float:  # fmt: skip
    """Fills in t q̇ + w + z and returns t, see `level_fit.keeping_direction`."""
    n, rows = int(program[slots.JOINTS]), int(program[slots.ROWS])
    d, Vt = int(found_of(program, desk, level)[slots.FREE]), further(desk, int(record_of(program, level)[slots.RIGHT]))
    roots, unit, along = stack(0.0, ONE, UNKNOWNS), stack(0.0, ONE, UNKNOWNS), stack(0.0, ONE, UNKNOWNS)
    motion, largest = stack(0.0, ONE, UNKNOWNS), 0.0
    for c in range(n):
        largest = max(largest, abs(wish[c]))
    less = HUGE / largest if largest > HUGE else 1.0
    for c in range(n):
        motion[c] = wish[c] * less
    largest *= less
    rank = costs(program, desk, level, stride, roots)
    for i in range(rank):
        unit[i] = roots[i] * dot(further(Vt, i * n), motion, n) / largest if largest > 0.0 else 0.0
    size = length_of(unit, rank)
    if size == 0.0:
        return less * float(slowed(program, desk, lower, upper, qdot, motion, change))
    for i in range(rank):
        unit[i] /= size
    directions, kept = further(desk, int(program[slots.SCRATCH])), stack(0.0, ONE, MATRIX)
    room = further(directions, (n + 1 + rows) * (n + 1))
    aid_directions(n, d, rank, Vt, roots, unit, largest * size, kept)
    for c in range(n):
        kept[c * d] = motion[c] * SHARE_SCALE
        along[c] = 0.0
        for i in range(rank):
            along[c] += roots[i] * unit[i] * Vt[i * n + c]
    cap = further(directions, n * d)
    for i in range(d):
        cap[i] = 0.0
        for c in range(n):
            directions[c * d + i] = kept[c * d + i]
            cap[i] += along[c] * kept[c * d + i]
    room[2 * n] = largest * size  # not further along the wish than wanted
    constrain(program, desk, lower, upper, qdot, directions, d, 1, room)
    wanted, y = stack(0.0, ONE, UNKNOWNS), stack(0.0, ONE, UNKNOWNS)
    for i in range(d):
        wanted[i] = 0.0
    wanted[0] = SHARE_SCALE
    nearest_inside(directions, room, n, rows + 1, d, wanted, y)
    for c in range(n):
        change[c] = dot(further(kept, c * d), y, d)
    share = max(0.0, min(1.0, y[0] * SHARE_SCALE))
    return less * (1.0 if share > 1.0 - ROUNDING else share)


@called
def aid_directions(
    n: int, d: int, rank: int, Vt: Pointer, roots: Pointer, unit: Pointer, size: float, directions: Pointer
) -> None:
    """Fills columns 1 to d of directions, (n, d): turns across the unit wish, then motions that do not move the level.

    The turns are the columns of a Householder reflection that takes the unit wish to its first axis.
    """
    mirror, square = stack(0.0, ONE, UNKNOWNS), 0.0
    for i in range(rank):
        mirror[i] = unit[i]
    mirror[0] += 1.0 if unit[0] >= 0.0 else -1.0
    for i in range(rank):
        square += mirror[i] * mirror[i]
    for j in range(1, d):
        for c in range(n):
            directions[c * d + j] = 0.0
        if j < rank:
            for i in range(rank):
                entry = ((1.0 if i == j else 0.0) - 2.0 * mirror[i] * mirror[j] / square) * (TURN * size) / roots[i]
                for c in range(n):
                    directions[c * d + j] += entry * Vt[i * n + c]
        else:
            for c in range(n):
                directions[c * d + j] = size / roots[j] * Vt[j * n + c]


@called
def fit(
    program: Pointer, desk: Pointer, level: int, lower: Pointer, upper: Pointer, qdot: Pointer, stride: float,
    motion: Pointer, change: Pointer,
) -> float:  # fmt: skip
    """Fills in the motion that a level gets, by the limiter; returns its share of the wish."""
    n, limiter = int(program[slots.JOINTS]), int(program[slots.LIMITER])
    share = float(slowed(program, desk, lower, upper, qdot, motion, change))
    if share == 1.0 or limiter == slots.SCALING:
        return share
    if limiter == slots.SATURATION or limiter == slots.KEEPING:
        return keeping_direction(program, desk, level, lower, upper, qdot, stride, motion, change)
    slower = stack(0.0, ONE, VECTOR)
    within_speeds(program, desk, qdot, motion, slower)
    if limiter == slots.NEAREST:
        nearest(program, desk, level, lower, upper, qdot, stride, slower, change)
        return share_of(program, desk, level, motion, change)
    if largest_step(program, desk, lower, upper, qdot, slower) == 1.0:
        for c in range(n):
            change[c] = slower[c]
        return share
    share = keeping_direction(program, desk, level, lower, upper, qdot, stride, slower, change)
    if share < 1.0:
        there, aside = stack(0.0, ONE, VECTOR), stack(0.0, ONE, VECTOR)
        for c in range(n):
            there[c], slower[c] = qdot[c] + change[c], (1.0 - share) * slower[c]
        nearest(program, desk, level, lower, upper, there, stride, slower, aside)
        for c in range(n):
            change[c] += aside[c]
    return share_of(program, desk, level, motion, change)
