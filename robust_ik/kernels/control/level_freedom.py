"""A level's Jacobian in the freedom left to it, and the motion that its gain formula makes of what it misses.

The compiled form of `within_bounds.null_space`, `within_bounds.filtered_motion` and `within_bounds.overshoot_limit`,
which have the reasons.
"""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, call_gain, further, sizes, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.polyhedron_projection import dot
from robust_ik.kernels.matrices.small_svd import decompose_some

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
def reduce(program: Pointer, desk: Pointer, level: int, width: Sizes) -> bool:
    """Decomposes J in the freedom left to a level; False if J is not finite."""
    d = int(program[slots.JOINTS])
    if level > 0:
        above = found_of(program, desk, level - 1)
        d = int(above[slots.FREE]) - int(above[slots.CLOSED])
    return reduce_to(program, desk, level, d, width)


@called
def reduce_to(program: Pointer, desk: Pointer, level: int, d: int, width: Sizes) -> bool:
    """Decomposes J in the freedom of d dimensions that is left to a level, or in that of all joints if d = n."""
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    m = int(record[slots.M])
    J, U = further(desk, int(record[slots.JACOBIAN])), further(desk, int(record[slots.LEFT]))
    s, own = further(desk, int(record[slots.SIGMA])), further(desk, int(record[slots.OWN]))
    Vt = further(desk, int(record[slots.RIGHT]))
    count = min(m, d)
    found[slots.FREE], found[slots.COUNT] = float(d), float(count)
    if d == n:
        good = decompose_some(J, U, s, Vt, m, n, n, 1, width, width, 0.0)
        for i in range(count):
            own[i] = s[i]
    else:
        good = values(J, m, n, own, width)
        if d > 0:
            good &= reduce_in(J, basis_of(program, desk, level), m, n, d, U, s, Vt, width)
    rank, closed, least = 0, 0, max(program[slots.RELEASE], RANK_TOLERANCE) * own[0]
    for i in range(count):
        rank += s[i] > RANK_TOLERANCE * own[0]
        closed += s[i] > least
    if d < n:
        for i in range(rank, count):
            s[i] = 0.0
    found[slots.RANK], found[slots.CLOSED] = float(rank), float(closed)
    return good


@called
def values(J: Pointer, m: int, n: int, own: Pointer, width: Sizes) -> bool:
    """Fills in the singular values of J; of rows with one entry each in different columns, as of joints, at once."""
    used, simple = stack(0.0, ONE, VECTOR), m <= n
    for c in range(n):
        used[c] = 0.0
    for r in range(m if simple else 0):
        entries = 0
        for c in range(n):
            if J[r * n + c] != 0.0:
                entries += 1
                simple &= used[c] == 0.0
                used[c] = 1.0
                own[r] = abs(J[r * n + c])
        simple &= entries == 1
    if simple:
        for r in range(1, m):
            value, place = own[r], r
            while place > 0 and own[place - 1] < value:
                own[place] = own[place - 1]
                place -= 1
            own[place] = value
        return True
    U, Vt = stack(0.0, ONE, MATRIX), stack(0.0, ONE, MATRIX)
    return decompose_some(J, U, own, Vt, m, n, min(m, n), 1, width, width, 0.0)


@called
def reduce_in(
    J: Pointer, basis: Pointer, m: int, n: int, d: int, U: Pointer, s: Pointer, Vt: Pointer, width: Sizes
) -> bool:
    """Decomposes J in the freedom of d rows: Vt gets d directions of length n."""
    left, turned = stack(0.0, ONE, MATRIX), stack(0.0, ONE, MATRIX)
    for r in range(m):
        for i in range(d):
            left[r * d + i] = dot(further(J, r * n), further(basis, i * n), n)
    good = decompose_some(left, U, s, turned, m, d, d, 1, width, width, 0.0)
    for i in range(d):
        for c in range(n):
            total = 0.0
            for k in range(d):
                total += turned[i * d + k] * basis[k * n + c]
            Vt[i * n + c] = total
    return good


@called
def project(program: Pointer, desk: Pointer, level: int, motion: Pointer) -> None:
    """Replaces a motion by its part in the freedom of a level."""
    n, d = int(program[slots.JOINTS]), int(found_of(program, desk, level)[slots.FREE])
    if d == n:
        return
    kept = stack(0.0, ONE, VECTOR)
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
def fill_gains(
    program: Pointer, record: Pointer, s: Pointer, count: int, largest: float, gains: Pointer
) -> None:  # fmt: skip
    """Fills in the gains φ(σ) of the level's formula, 0 for σ = 0, thresholds relative to `largest`."""
    address, parameters = int(record[slots.GAIN]), further(program, int(record[slots.PARAMETERS]))
    product, first = 1.0, s[0]
    if record[slots.RELATIVE] > 0.0 and s[0] < largest * BESIDE:
        product, first = largest, largest
    for i in range(count):
        product *= s[i]
    for i in range(count):
        gains[i] = 0.0
        if s[i] > 0.0:
            smallest = s[count - 1]
            place = (s[i], first, smallest, product if smallest > 0.0 else 0.0, float(count - 1 - i), parameters)
            gains[i] = call_gain(address, place)


@called
def filtered(
    program: Pointer, record: Pointer, U: Pointer, s: Pointer, Vt: Pointer, count: int, largest: float,
    wanted: Pointer, motion: Pointer,
) -> None:  # fmt: skip
    """Fills in the motion V φ Uᵀ wanted by the level's gain formula, thresholds relative to `largest`."""
    n, m, longest, gains = int(program[slots.JOINTS]), int(record[slots.M]), 0.0, stack(0.0, ONE, VECTOR)
    for c in range(n):
        motion[c] = 0.0
    for r in range(m):
        longest = max(longest, abs(wanted[r]))
    shorter = LARGEST / longest if longest > LARGEST else 1.0
    fill_gains(program, record, s, count, largest, gains)
    for i in range(count):
        if s[i] > 0.0:
            along = 0.0
            for r in range(m):
                along += wanted[r] * U[r * count + i]
            share = gains[i] * (shorter * along)
            for c in range(n):
                motion[c] += share * Vt[i * n + c]


@called
def level_motion(program: Pointer, desk: Pointer, level: int, width: Sizes) -> None:
    """Fills MOTION with what the level's gain formula makes of what it still misses."""
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    motion, wanted = further(desk, int(program[slots.MOTION])), further(desk, int(record[slots.MISSING]))
    s, own = further(desk, int(record[slots.SIGMA])), further(desk, int(record[slots.OWN]))
    U, Vt = further(desk, int(record[slots.LEFT])), further(desk, int(record[slots.RIGHT]))
    if record[slots.WAY] == slots.IN_FREEDOM or (record[slots.WAY] == slots.DECOUPLED and level == 0):
        for c in range(n):
            motion[c] = 0.0
        if found[slots.RANK] > 0.0:
            filtered(program, record, U, s, Vt, int(found[slots.COUNT]), own[0], wanted, motion)
    else:
        m, J = int(record[slots.M]), further(desk, int(record[slots.JACOBIAN]))
        left, right, sigma = stack(0.0, ONE, MATRIX), stack(0.0, ONE, MATRIX), stack(0.0, ONE, VECTOR)
        decompose_some(J, left, sigma, right, m, n, min(m, n), 1, width, width, 0.0)
        for c in range(n):
            motion[c] = 0.0
        if sigma[0] > 0.0:
            filtered(program, record, left, sigma, right, min(m, n), sigma[0],
                     further(desk, int(record[slots.X])), motion)  # fmt: skip
    project(program, desk, level, motion)


@called
def steady(program: Pointer, desk: Pointer, level: int, wanted: Pointer, size: float) -> None:
    """Shortens MOTION along directions in which the level would overshoot."""
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    rank, count, m, dt = int(found[slots.RANK]), int(found[slots.COUNT]), int(record[slots.M]), program[slots.DT]
    if rank == 0 or size == 0.0 or dt == 0.0:
        return
    s, U = further(desk, int(record[slots.SIGMA])), further(desk, int(record[slots.LEFT]))
    Vt, own = further(desk, int(record[slots.RIGHT])), further(desk, int(record[slots.OWN]))
    motion, cut, any_cut = further(desk, int(program[slots.MOTION])), stack(0.0, ONE, VECTOR), False
    for i in range(rank):
        part = 0.0
        for r in range(m):
            part += wanted[r] / size * U[r * count + i]
        along, most = dot(further(Vt, i * n), motion, n), 2.0 / dt * (s[i] / own[0]) * abs(part)
        any_cut |= abs(along) > most * SPARE
        cut[i] = max(-most, min(most, along)) - along
    if any_cut:
        for i in range(rank):
            for c in range(n):
                motion[c] += cut[i] * Vt[i * n + c]


@called
def length_of(vector: Pointer, size: int) -> float:
    """‖x‖, exact also where squares would overflow or vanish."""
    largest, total = 0.0, 0.0
    for i in range(size):
        largest = max(largest, abs(vector[i]))
    unit = 1.0 if largest == 0.0 or 1e-140 < largest < 1e140 else largest
    for i in range(size):
        total += (vector[i] / unit) ** 2
    return unit * math.sqrt(total)
