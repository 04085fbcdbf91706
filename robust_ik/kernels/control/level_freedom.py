"""A level's Jacobian in the freedom left to it, and the motion that its gain formula makes of what it misses.

The compiled form of `within_bounds.null_space`, `within_bounds.filtered_motion` and `within_bounds.overshoot_limit`,
which have the reasons.
"""

from __future__ import annotations

import math
from typing import Any

from numba.extending import overload

from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.simd_lanes import COUNT, LANES, Number, somewhere, where
from robust_ik.kernels.compiler.stack_memory import (
    ONE,
    Pointer,
    Sizes,
    call_gain,
    each_lane,
    further,
    lanes_of,
    sizes,
    stack,
)
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.calming import asked_share
from robust_ik.kernels.matrices.small_products import dot, multiply
from robust_ik.kernels.matrices.small_svd import decompose_some
from robust_ik.kernels.matrices.svd_side_by_side import decompose_eight, from_lane, into_lane

RANK_TOLERANCE = 1e-12
"""As `kinematics.svd.RANK_TOLERANCE`."""
BESIDE = 1 - 1e-12
"""σ₁ of J N below this fraction of that of J is told to formulas as a singular value beside those of J N."""
LARGEST = 1e100
"""What is missing is shortened to this, as to `checks.LARGEST_PARAMETER`: its products could overflow."""
SPARE = 1 + 1e-12
"""A motion may exceed what is steady by this factor, for rounding."""
MATRIX, VECTOR = sizes(32 * 32), sizes(32)


@called
def record_of(program: Pointer, level: int) -> Pointer:
    """The record of a level."""
    return further(program, slots.HEAD + level * slots.RECORD)


@called
def found_of(program: Pointer, desk: Pointer, level: int) -> Pointer:
    """The numbers found of a level."""
    return further(desk, int(record_of(program, level)[slots.FOUND]))


@called
def basis_of(program: Pointer, desk: Pointer, level: int) -> Pointer:
    """The basis of the freedom of a level that is not the first, as rows."""
    above = found_of(program, desk, level - 1)
    rows = further(desk, int(record_of(program, level - 1)[slots.RIGHT]))
    return further(rows, int(above[slots.CLOSED]) * int(program[slots.JOINTS]))


@called
def reduce(program: Pointer, desk: Pointer, level: int, width: Sizes) -> None:
    """Decomposes J in the freedom left to a level."""
    d = int(program[slots.JOINTS])
    if level > 0:
        above = found_of(program, desk, level - 1)
        d = int(above[slots.FREE]) - int(above[slots.CLOSED])
    reduce_to(program, desk, level, d, width)


@called
def reduce_to(program: Pointer, desk: Pointer, level: int, d: int, width: Sizes) -> None:
    """Decomposes J in the freedom of d dimensions that is left to a level, or in that of all joints if d = n."""
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    m = int(record[slots.M])
    J, U = further(desk, int(record[slots.JACOBIAN])), further(desk, int(record[slots.LEFT]))
    s, own = further(desk, int(record[slots.SIGMA])), further(desk, int(record[slots.OWN]))
    Vt = further(desk, int(record[slots.RIGHT]))
    count = min(m, d)
    found[slots.FREE], found[slots.COUNT] = float(d), float(count)
    if d == n:
        decompose(J, U, s, Vt, m, n, n, width)
        for i in range(count):
            own[i] = s[i]
    else:
        values(J, m, n, own, width)
        if d > 0:
            reduce_in(J, basis_of(program, desk, level), m, n, d, U, s, Vt, width)
    rank, closed, least = 0.0, 0.0, max(program[slots.RELEASE], RANK_TOLERANCE) * own[0]
    for i in range(count):
        rank += where(s[i] > RANK_TOLERANCE * own[0], 1.0, 0.0)
        closed += where(s[i] > least, 1.0, 0.0)
    for i in range(count if d < n else 0):
        s[i] = where(rank > float(i), s[i], 0.0)
    found[slots.RANK], found[slots.CLOSED] = rank, closed


def decompose(J: Pointer, U: Pointer, s: Pointer, Vt: Pointer, m: int, n: int, right: int, width: Sizes) -> None:
    """Decomposes J, or that of every lane; see `decompose_some`."""
    raise NotImplementedError


@overload(decompose, strict=False, inline="always")
def _decompose(J: Any, U: Any, s: Any, Vt: Any, m: Any, n: Any, right: Any, width: Any) -> Any:
    if J.dtype == LANES:
        return lambda J, U, s, Vt, m, n, right, width: decompose_eight(J, U, s, Vt, m, n, right, width)
    return lambda J, U, s, Vt, m, n, right, width: decompose_some(J, U, s, Vt, m, n, right, 1, width, width, 0.0)


@called
def values_together(J: Pointer, m: int, n: int, own: Pointer, width: Sizes) -> bool:
    """Fills in the singular values of J; of rows with one entry each in different columns, as of joints, at once.

    False, with nothing filled in, if J is zero at other places in some lanes than in others.
    """
    used, simple, alike = stack(0.0, ONE, VECTOR), m <= n, True
    for c in range(n):
        used[c] = 0.0
    for r in range(m if simple else 0):
        entries = 0
        for c in range(n):
            entry = abs(J[r * n + c])
            if somewhere(entry > 0.0):
                alike &= not somewhere(entry <= 0.0)
                entries += 1
                simple &= used[c] == 0.0
                used[c] = 1.0
                own[r] = entry
        simple &= entries == 1
    if alike and simple:
        for r in range(1, m):
            for place in range(r, 0, -1):
                above, below = own[place - 1], own[place]
                own[place - 1], own[place] = max(above, below), min(above, below)
    elif alike:
        U, Vt = stack(J[0], ONE, MATRIX), stack(J[0], ONE, MATRIX)
        decompose(J, U, own, Vt, m, n, min(m, n), width)
    return alike


def values(J: Pointer, m: int, n: int, own: Pointer, width: Sizes) -> None:
    """Fills in the singular values of J, or of that of every lane."""
    raise NotImplementedError


@overload(values, strict=False)
def _values(J: Any, m: Any, n: Any, own: Any, width: Any) -> Any:
    def each(J: Pointer, m: int, n: int, own: Pointer, width: Sizes) -> None:
        if not values_together(J, m, n, own, width):
            given, found = stack(0.0, ONE, MATRIX), stack(0.0, ONE, VECTOR)
            for lane in range(COUNT):
                from_lane(each_lane(J), lane, m * n, given)
                values_together(given, m, n, found, width)
                into_lane(found, min(m, n), each_lane(own), lane)

    def alone(J: Pointer, m: int, n: int, own: Pointer, width: Sizes) -> None:
        values_together(J, m, n, own, width)

    return each if J.dtype == LANES else alone


@called
def reduce_in(
    J: Pointer, basis: Pointer, m: int, n: int, d: int, U: Pointer, s: Pointer, Vt: Pointer, width: Sizes
) -> None:
    """Decomposes J in the freedom of d rows: Vt gets d directions of length n."""
    left, turned = stack(J[0], ONE, MATRIX), stack(J[0], ONE, MATRIX)
    for r in range(m):
        for i in range(d):
            left[r * d + i] = dot(further(J, r * n), further(basis, i * n), n)
    decompose(left, U, s, turned, m, d, d, width)
    multiply(turned, d, d, basis, n, Vt)


@called
def project(program: Pointer, desk: Pointer, level: int, motion: Pointer) -> None:
    """Replaces a motion by its part in the freedom of a level."""
    n, d = int(program[slots.JOINTS]), int(found_of(program, desk, level)[slots.FREE])
    if d == n:
        return
    kept = stack(motion[0], ONE, VECTOR)
    for c in range(n):
        kept[c] = 0.0
    for i in range(d):
        row = further(basis_of(program, desk, level), i * n)
        share = dot(row, motion, n)
        for c in range(n):
            kept[c] += share * row[c]
    for c in range(n):
        motion[c] = kept[c]


@called
def fill_gains(program: Pointer, record: Pointer, s: Pointer, count: int, own: Pointer, gains: Pointer) -> None:
    """Fills in the gains φ(σ) of the level's formula, 0 for σ = 0, thresholds relative to the first of `own`."""
    address, parameters = int(record[slots.GAIN]), further(program, int(record[slots.PARAMETERS]))
    product, first, largest, one = 1.0, s[0], own[0], stack(s[0], ONE, GIVEN)
    if record[slots.RELATIVE] > 0.0:
        product = where(first < largest * BESIDE, largest, 1.0)
        first = where(first < largest * BESIDE, largest, first)
    for i in range(count):
        product *= s[i]
    for i in range(count):
        gains[i] = s[i] * 0.0
        if somewhere(s[i] > 0.0):
            smallest = s[count - 1]
            one[0], one[1], one[2] = s[i], first, smallest
            one[3] = where(smallest > 0.0, product, 0.0)
            to_gain(address, one, float(count - 1 - i), parameters)
            gains[i] = where(s[i] > 0.0, one[0], 0.0)


@called
def filtered(
    program: Pointer, record: Pointer, U: Pointer, s: Pointer, Vt: Pointer, count: int, own: Pointer,
    wanted: Pointer, motion: Pointer,
) -> None:  # fmt: skip
    """Fills in the motion V φ Uᵀ wanted by the level's gain formula, thresholds relative to the first of `own`."""
    n, m, longest, gains = int(program[slots.JOINTS]), int(record[slots.M]), 0.0, stack(s[0], ONE, VECTOR)
    for c in range(n):
        motion[c] = 0.0
    for r in range(m):
        longest = max(longest, abs(wanted[r]))
    shorter = where(longest > LARGEST, LARGEST / longest, 1.0)
    fill_gains(program, record, s, count, own, gains)
    for i in range(count):
        if somewhere(s[i] > 0.0):
            along = 0.0
            for r in range(m):
                along += wanted[r] * U[r * count + i]
            share = where(s[i] > 0.0, gains[i] * (shorter * along), 0.0)
            for c in range(n):
                motion[c] += share * Vt[i * n + c]


GIVEN = sizes(4)
"""What a gain formula is given that depends on J."""


@inlined
def to_gain(address: int, given: Pointer, after: float, parameters: Pointer) -> None:
    """Replaces σ, the first of four numbers, by its gain."""
    numbers, lanes = each_lane(given), lanes_of(given[0])
    for lane in range(lanes):
        place = (
            numbers[lane], numbers[lanes + lane], numbers[2 * lanes + lane], numbers[3 * lanes + lane],
            after, parameters,
        )  # fmt: skip
        numbers[lane] = call_gain(address, place)


@called
def asked_velocity(program: Pointer, desk: Pointer, level: int, asked: Pointer) -> None:
    """Fills in the share of a level's ẋ that it asks for."""
    record, share = record_of(program, level), asked_share(program, desk)
    x = further(desk, int(record[slots.X]))
    for r in range(int(record[slots.M])):
        asked[r] = share * x[r]


@called
def level_motion(program: Pointer, desk: Pointer, level: int, width: Sizes) -> None:
    """Fills MOTION with what the level's gain formula makes of what it still misses."""
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    motion, wanted = further(desk, int(program[slots.MOTION])), further(desk, int(record[slots.MISSING]))
    s, own = further(desk, int(record[slots.SIGMA])), further(desk, int(record[slots.OWN]))
    U, Vt = further(desk, int(record[slots.LEFT])), further(desk, int(record[slots.RIGHT]))
    if record[slots.WAY] == slots.IN_FREEDOM or (record[slots.WAY] == slots.DECOUPLED and level == 0):
        filtered(program, record, U, s, Vt, int(found[slots.COUNT]), own, wanted, motion)
    else:
        m, J = int(record[slots.M]), further(desk, int(record[slots.JACOBIAN]))
        left, right, sigma = stack(J[0], ONE, MATRIX), stack(J[0], ONE, MATRIX), stack(J[0], ONE, VECTOR)
        asked = stack(J[0], ONE, VECTOR)
        asked_velocity(program, desk, level, asked)
        decompose(J, left, sigma, right, m, n, min(m, n), width)
        filtered(program, record, left, sigma, right, min(m, n), sigma, asked, motion)
    project(program, desk, level, motion)


@called
def steady(program: Pointer, desk: Pointer, level: int, wanted: Pointer, length: Pointer) -> None:
    """Shortens MOTION along directions in which the level would overshoot; `length` is that of what is wanted."""
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    count, m, dt = int(found[slots.COUNT]), int(record[slots.M]), program[slots.DT]
    if dt == 0.0:
        return
    s, U = further(desk, int(record[slots.SIGMA])), further(desk, int(record[slots.LEFT]))
    Vt, own = further(desk, int(record[slots.RIGHT])), further(desk, int(record[slots.OWN]))
    motion, cut, any_cut = further(desk, int(program[slots.MOTION])), stack(s[0], ONE, VECTOR), 0.0
    rank = where(length[0] > 0.0, found[slots.RANK], 0.0)
    for i in range(count):
        part = 0.0
        for r in range(m):
            part += wanted[r] / length[0] * U[r * count + i]
        along, most = dot(further(Vt, i * n), motion, n), 2.0 / dt * (s[i] / own[0]) * abs(part)
        any_cut = where((rank > float(i)) & (abs(along) > most * SPARE), 1.0, any_cut)
        cut[i] = where(rank > float(i), max(-most, min(most, along)) - along, 0.0)
    if somewhere(any_cut > 0.0):
        for i in range(count):
            for c in range(n):
                motion[c] = where(any_cut > 0.0, motion[c] + cut[i] * Vt[i * n + c], motion[c])


@called
def length_of(vector: Pointer, size: int) -> Number:
    """‖x‖, exact also where squares would overflow or vanish."""
    largest, total = 0.0, 0.0
    for i in range(size):
        largest = max(largest, abs(vector[i]))
    plain = (largest > 1e-140) & (largest < 1e140)
    unit = where(plain, 1.0, where(largest > 0.0, largest, 1.0))
    for i in range(size):
        part = vector[i] / unit
        total += part * part
    return unit * math.sqrt(total)
