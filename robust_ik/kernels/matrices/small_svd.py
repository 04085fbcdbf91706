"""Singular value decomposition of small matrices, one or many."""

from __future__ import annotations

import math
from typing import Any

from numba.extending import overload

from robust_ik.checks import Array
from robust_ik.kernels.compiler.compiling import called, filled, given, inlined, kernel
from robust_ik.kernels.compiler.simd_lanes import COUNT, LANES, Number, spread, where
from robust_ik.kernels.compiler.stack_memory import (
    NONE,
    ONE,
    W8,
    W16,
    Pointer,
    Sizes,
    by_eights,
    each_lane,
    further,
    lanes_of,
    pointer,
    stack,
)
from robust_ik.kernels.matrices.jacobi_rotations import ALL, dot, orthogonalise
from robust_ik.kernels.matrices.row_reflections import triangulate, unevenness

TINY = 1e-280
"""Squared length below which the length of a row is computed anew, since its squares may have underflowed."""
SKEW = 1e-12
"""Cosine above which two unit rows are not orthogonal."""
SMALLEST = 1e-290
"""Singular values below this, absolutely or as a fraction of about σ₁, are zero: 1/σ cannot overflow, and no vector
comes from denormal numbers, which have lost digits.
"""
TOGETHER = 3
"""Least number of matrices that are decomposed side by side."""


@inlined
def length(A: Pointer, i: int, lane: int, squared: float, width: Sizes, lanes: int) -> float:
    """The length of row i, whose square is about `squared`; exact also where squares underflow."""
    if squared >= TINY:
        return math.sqrt(squared)
    P = len(width)
    largest = 0.0
    for c in range(P):
        largest = max(largest, abs(A[(i * P + c) * lanes + lane]))
    if largest == 0.0:
        return 0.0
    total = 0.0
    for c in range(P):
        total += (A[(i * P + c) * lanes + lane] / largest) ** 2
    return largest * math.sqrt(total)


@inlined
def orthonormal(rows: Pointer, count: int, width: Sizes) -> int:
    """How many unit rows, from the first one on, are orthogonal to each other.

    Rows that consist of rounding errors may not be orthogonal.
    """
    good = count
    for r in range(1, count):
        for i in range(r):
            if r < good and abs(dot(rows, i, r, width)) > SKEW:
                good = r
    return good


@called
def complete(rows: Pointer, known: int, count: int, n: int, width: Sizes) -> None:
    """Appends orthonormal rows of length n: each is the part of a unit vector that is orthogonal to the rows before."""
    P = len(width)
    for r in range(known, count):
        best, most = 0.0, -1.0
        for k in range(n):
            new = 1.0
            for i in range(r):
                new -= rows[i * P + k] * rows[i * P + k]
            best, most = where(new > most, float(k), best), where(new > most, new, most)
        for c in range(P):
            rows[r * P + c] = where((best >= float(c)) & (best <= float(c)), 1.0, 0.0)
        for _ in range(2):
            for i in range(r):
                add_row(rows, r, -dot(rows, i, r, width), i, width)
            add_row(rows, r, 1.0 / math.sqrt(dot(rows, r, r, width)) - 1.0, r, width)


def add_row(rows: Pointer, r: int, factor: Number, i: int, width: Sizes) -> None:
    """Adds a multiple of row i to row r."""
    raise NotImplementedError


@overload(add_row, strict=False, inline="always")
def _add_row(rows: Any, r: Any, factor: Any, i: Any, width: Any) -> Any:
    def one_by_one(rows: Pointer, r: int, factor: Number, i: int, width: Sizes) -> None:
        P = len(width)
        for c in range(P):
            rows[r * P + c] = rows[r * P + c] + factor * rows[i * P + c]

    def by_row(rows: Pointer, r: int, factor: Number, i: int, width: Sizes) -> None:
        eights, P = by_eights(rows), len(width) // 8
        for c in range(P):
            eights[r * P + c] = eights[r * P + c] + factor * eights[i * P + c]

    return one_by_one if rows.dtype == LANES else by_row


@inlined
def write(target: Pointer, height: int, breadth: int, rows: Pointer, transposed: bool, width: Sizes) -> None:
    """Copies rows into a matrix, or into its columns if `transposed`."""
    P = len(width)
    for r in range(height):
        for c in range(breadth):
            target[r * breadth + c] = rows[c * P + r] if transposed else rows[r * P + c]


@called
def scale(J: Pointer, size: int) -> float:
    """The power of two by which a matrix of `size` entries is divided to have entries of at most 1."""
    largest = 0.0
    for i in range(size):
        largest = max(largest, abs(J[i]))
    return above(largest)


@called
def above(largest: float) -> float:
    """The power of two above a number, within reason; 1 for 0."""
    return math.ldexp(1.0, max(min(math.frexp(largest)[1], 1000), -1000)) if largest > 0.0 else 1.0


@called
def decompose_some(
    J: Pointer,
    U: Pointer,
    s: Pointer,
    Vt: Pointer,
    m: int,
    n: int,
    right: int,
    count: int,
    width: Sizes,
    carried: Sizes,
    zero: Number,
) -> bool:
    """Decomposes `count` matrices, at most as many as a Number has lanes; False if not all is finite.

    Args:
        J: Matrices (m, n), one after another.
        U: Filled, (m, k) each, k = min(m, n).
        s: Filled, (k,) each.
        Vt: Filled, (right, n) each; `right` is k or n.
        m: Number of rows.
        n: Number of columns.
        right: How many right singular vectors to compute.
        count: How many matrices.
        width: At least as long as the matrices are wide and high.
        carried: As `width` for vectors; NONE for values alone.
        zero: 0 of one number, or of lanes.
    """
    L, P, Q = lanes_of(zero), len(width), len(carried)
    wide = m <= n
    k, long = min(m, n), max(m, n)
    rows, along, norms = stack(zero, width, width), stack(zero, width, carried), stack(zero, ONE, width)
    A, C, squares = each_lane(rows), each_lane(along), each_lane(norms)
    order, sigma, factors = stack(0.0, ONE, width), stack(0.0, ONE, width), stack(0.0, ONE, W8)
    vectors, spoilt = stack(0.0, width, width), 0.0
    for x in range(k * P):
        rows[x] = zero
    for x in range(k * Q):
        along[x] = zero
    for lane in range(count):
        given = further(J, lane * m * n)
        factors[lane] = scale(given, m * n)
        divisor = 1.0 / factors[lane]
        for i in range(m):
            for c in range(n):
                A[(i * P + c if wide else c * P + i) * L + lane] = given[i * n + c] * divisor
                spoilt += given[i * n + c] * 0.0
    if Q > 0:
        for i in range(k):
            along[i * Q + i] = zero + 1.0
    if L == 1 and unevenness(J, m, n, wide) > 0.0:
        triangulate(A, C, k, long, width, carried)
    orthogonalise(rows, along, k, width, carried, norms, ALL, zero)
    for lane in range(count):
        for i in range(k):
            size = length(A, i, lane, squares[i * L + lane], width, L)
            sigma[i] = size if size >= SMALLEST else 0.0
        known = sort(sigma, order, k)
        for place in range(k):
            value = sigma[int(order[place])] * factors[lane]
            spoilt += value * 0.0
            s[lane * k + place] = value if value >= SMALLEST else 0.0
        if Q > 0:
            for place in range(known):
                i = int(order[place])
                for c in range(P):
                    vectors[place * P + c] = A[(i * P + c) * L + lane] / sigma[i]
            complete(vectors, orthonormal(vectors, known, width), max(k, right), long, width)
            left_place, right_place = further(U, lane * m * k), further(Vt, lane * right * n)
            if wide:
                write(right_place, right, n, vectors, False, width)
            else:
                write(left_place, m, k, vectors, True, width)
            for place in range(k):
                i = int(order[place])
                for c in range(k):
                    vectors[place * P + c] = C[(i * Q + c) * L + lane]
            if wide:
                write(left_place, m, k, vectors, True, width)
            else:
                write(right_place, right, n, vectors, False, width)
    return not math.isnan(spoilt)


@inlined
def sort(sigma: Pointer, order: Pointer, k: int) -> int:
    """Sorts k numbers into descending order, as indices; returns how many are not zero."""
    known = 0
    for i in range(k):
        known += sigma[i] > 0.0
        place = i
        while place > 0 and sigma[int(order[place - 1])] < sigma[i]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = i
    return known


@called
def decompose_few(
    J: Pointer,
    U: Pointer,
    s: Pointer,
    Vt: Pointer,
    m: int,
    n: int,
    right: int,
    count: int,
    width: Sizes,
    carried: Sizes,
    zero: Number,
) -> bool:
    """`decompose_some`, and those anew, alone, that are too uneven to be decomposed side by side."""
    good = decompose_some(J, U, s, Vt, m, n, right, count, width, carried, zero)
    if lanes_of(zero) > 1:
        for e in range(count):
            from_J = further(J, e * m * n)
            if unevenness(from_J, m, n, m <= n) > 0.0:
                decompose_some(
                    from_J, further(U, e * m * min(m, n)), further(s, e * min(m, n)), further(Vt, e * right * n),
                    m, n, right, 1, width, carried, 0.0,
                )  # fmt: skip
    return good


@inlined
def decompose(J: Array, U: Array, s: Array, Vt: Array, width: Sizes, carried: Sizes) -> bool:
    """Decomposes every J, side by side if there are several; False if not all is finite."""
    begin, count, good, m, n = 0, len(J), True, J.shape[1], J.shape[2]
    k, right = min(m, n), Vt.shape[1]
    from_J, to_U, to_s, to_Vt = pointer(J), pointer(U), pointer(s), pointer(Vt)
    while count - begin >= TOGETHER:
        some = min(COUNT, count - begin)
        good &= decompose_few(
            further(from_J, begin * m * n), further(to_U, begin * m * k), further(to_s, begin * k),
            further(to_Vt, begin * right * n), m, n, right, some, width, carried, spread(0.0),
        )  # fmt: skip
        begin += some
    for e in range(begin, count):
        good &= decompose_some(
            further(from_J, e * m * n), further(to_U, e * m * k), further(to_s, e * k),
            further(to_Vt, e * right * n), m, n, right, 1, width, carried, 0.0,
        )  # fmt: skip
    return good


VECTORS = given(3), filled(3), filled(2), filled(3)
VALUES = given(3), filled(2)


@kernel(*VECTORS)
def vectors_8(J: Array, U: Array, s: Array, Vt: Array) -> bool:
    """Singular values and vectors of matrices with at most 8 rows and columns; False if not all is finite."""
    return decompose(J, U, s, Vt, W8, W8)


@kernel(*VECTORS)
def vectors_16(J: Array, U: Array, s: Array, Vt: Array) -> bool:
    """Singular values and vectors of matrices with at most 16 rows and columns; False if not all is finite."""
    return decompose(J, U, s, Vt, W16, W16)


@kernel(*VALUES)
def values_8(J: Array, s: Array) -> bool:
    """Singular values of matrices with at most 8 rows and columns; False if not all is finite."""
    return decompose(J, J, s, J, W8, NONE)


@kernel(*VALUES)
def values_16(J: Array, s: Array) -> bool:
    """Singular values of matrices with at most 16 rows and columns; False if not all is finite."""
    return decompose(J, J, s, J, W16, NONE)
