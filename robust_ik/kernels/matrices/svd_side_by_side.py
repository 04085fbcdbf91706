"""Singular value decompositions of eight matrices whose entries lie side by side, as lanes."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.simd_lanes import COUNT, root, spread, where
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, each_lane, stack
from robust_ik.kernels.matrices.jacobi_rotations import ALL, dot, orthogonalise
from robust_ik.kernels.matrices.row_reflections import unevenness
from robust_ik.kernels.matrices.small_svd import SKEW, SMALLEST, TINY, above, complete, decompose_some, write


@called
def from_lane(lanes: Pointer, lane: int, count: int, target: Pointer) -> None:
    """Copies `count` numbers out of a lane."""
    for i in range(count):
        target[i] = lanes[i * COUNT + lane]


@called
def into_lane(source: Pointer, count: int, lanes: Pointer, lane: int) -> None:
    """Copies `count` numbers into a lane."""
    for i in range(count):
        lanes[i * COUNT + lane] = source[i]


@called
def decompose_eight(J: Pointer, U: Pointer, s: Pointer, Vt: Pointer, m: int, n: int, right: int, width: Sizes) -> None:
    """`decompose_some` of a matrix in each lane, with the same bits; lanes that need more than all do are done alone.

    Args:
        J: (m, n), each entry eight lanes, as everything here.
        U: Filled, (m, k), k = min(m, n).
        s: Filled, (k,).
        Vt: Filled, (right, n); `right` is k or n.
        m: Number of rows.
        n: Number of columns.
        right: How many right singular vectors to compute.
        width: At least as long as the matrices are wide and high.
    """
    zero, P, wide = spread(0.0), len(width), m <= n
    k, long = min(m, n), max(m, n)
    rows, along, norms = stack(zero, width, width), stack(zero, width, width), stack(zero, ONE, width)
    vectors, others = stack(zero, width, width), stack(zero, width, width)
    factor, alone, largest = stack(zero, ONE, ONE), stack(zero, ONE, ONE), stack(zero, ONE, ONE)
    largest[0], alone[0] = zero, zero
    for i in range(m * n):
        largest[0] = max(largest[0], abs(J[i]))
    for lane in range(COUNT):
        each_lane(factor)[lane] = above(each_lane(largest)[lane])
    for x in range(k * P):
        rows[x], along[x] = zero, zero
    divisor = 1.0 / factor[0]
    for i in range(m):
        for c in range(n):
            rows[i * P + c if wide else c * P + i] = J[i * n + c] * divisor
    for i in range(k):
        along[i * P + i] = zero + 1.0
    if k > 1:
        alone[0] = where(unevenness(J, m, n, wide) > 0.0, 1.0, zero)
    orthogonalise(rows, along, k, width, width, norms, ALL, zero)
    sort_rows(rows, along, norms, k, vectors, others, s, alone, width)
    for i in range(k):
        value = s[i] * factor[0]
        alone[0] = where(value < math.inf, alone[0], 1.0)
        s[i] = where(value >= SMALLEST, value, zero)
    for r in range(1, k):
        for i in range(r):
            alone[0] = where(abs(dot(vectors, i, r, width)) <= SKEW, alone[0], 1.0)
    complete(vectors, k, max(k, right), long, width)
    if wide:
        write(Vt, right, n, vectors, False, width)
        write(U, m, k, others, True, width)
    else:
        write(U, m, k, vectors, True, width)
        write(Vt, right, n, others, False, width)
    for lane in range(COUNT):
        if each_lane(alone)[lane] > 0.0:
            decompose_lane(J, U, s, Vt, m, n, right, lane, width)


@called
def sort_rows(
    rows: Pointer, along: Pointer, norms: Pointer, k: int, vectors: Pointer, others: Pointer, s: Pointer,
    alone: Pointer, width: Sizes,
) -> None:  # fmt: skip
    """Sorts orthogonal rows by their length, the longest first, and brings them to length 1.

    Args:
        rows: k rows.
        along: k rows that are sorted with them.
        norms: Squared lengths of the rows.
        k: Number of rows.
        vectors: Filled with the rows.
        others: Filled with those along them.
        s: Filled with the lengths.
        alone: Set to 1 in lanes in which a row is too short for this.
        width: Length of the rows.
    """
    zero, P = spread(0.0), len(width)
    sigma, place = stack(zero, ONE, width), stack(zero, ONE, width)
    for i in range(k):
        alone[0] = where(norms[i] >= TINY, alone[0], 1.0)
        sigma[i] = root(norms[i])
    for i in range(k):
        place[i] = zero
        for j in range(k):
            before = sigma[j] >= sigma[i] if j < i else sigma[j] > sigma[i]
            place[i] += where(before, zero + 1.0, zero)
        for c in range(P):
            rows[i * P + c] /= sigma[i]
    sorted_rows, sorted_others, lengths = each_lane(vectors), each_lane(others), each_lane(s)
    from_rows, from_others, from_sigma, places = each_lane(rows), each_lane(along), each_lane(sigma), each_lane(place)
    for i in range(k):
        for lane in range(COUNT):
            to = int(places[i * COUNT + lane])
            lengths[to * COUNT + lane] = from_sigma[i * COUNT + lane]
            for c in range(P):
                sorted_rows[(to * P + c) * COUNT + lane] = from_rows[(i * P + c) * COUNT + lane]
            for c in range(k):
                sorted_others[(to * P + c) * COUNT + lane] = from_others[(i * P + c) * COUNT + lane]


@called
def decompose_lane(
    J: Pointer, U: Pointer, s: Pointer, Vt: Pointer, m: int, n: int, right: int, lane: int, width: Sizes
) -> None:
    """`decompose_some` of the matrix in one lane."""
    k = min(m, n)
    given, left, sigma = stack(0.0, width, width), stack(0.0, width, width), stack(0.0, ONE, width)
    turned = stack(0.0, width, width)
    from_lane(each_lane(J), lane, m * n, given)
    decompose_some(given, left, sigma, turned, m, n, right, 1, width, width, 0.0)
    into_lane(left, m * k, each_lane(U), lane)
    into_lane(sigma, k, each_lane(s), lane)
    into_lane(turned, right * n, each_lane(Vt), lane)
