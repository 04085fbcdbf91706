"""One-sided Jacobi: rotates the rows of a matrix until they are orthogonal. Every decomposition here uses it.

When the rows of J are orthogonal, their lengths are σᵢ and their directions vᵢ. A second matrix (an identity, a task
velocity) that is rotated with them becomes Uᵀ times itself. Pairs of rows are taken in round-robin order, so that m/2
rotations in a row do not wait for each other.

Source: Hestenes 1958; Demmel and Veselić 1992 for the accuracy: each σ has a relative error of a few ε κ, κ being the
condition of J with rows of unit length, however different these lengths are.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.extending import overload

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.simd_lanes import LANES, Number, folded, root, size, somewhere, where
from robust_ik.kernels.compiler.stack_memory import Pointer, Sizes, by_eights

MOST_ROWS = 32
"""Most rows of a matrix. Chosen: as many as two arms, a torso and a head have joints."""
SWEEPS = 40
"""Most sweeps, in case rounding keeps rows turning.

Chosen: random matrices take up to 12; LAPACK's dgesvj allows 30.
"""
ORTHOGONAL = (3e-16) ** 2
"""cos² of the angle between two rows up to which they are not rotated. Chosen: just above ε = 2.2e-16 of rounding."""
LAST = 1e-17
"""Largest squared cosine and tangent in a sweep after which no further sweep is needed: convergence is quadratic."""
ALL = -1.0
"""A floor below every row, even where rounding makes a squared length negative."""
SMALL, TINY = 1e-120, 1e-220
"""Squared lengths below which their product, or the square of one, may underflow."""


def _tournament(count: int) -> list[list[tuple[int, int]]]:
    """Round-robin order: rounds of disjoint pairs in which each row meets each other row once."""
    seats = list(range(count + count % 2))
    rounds = []
    for _ in range(len(seats) - 1):
        pairs = zip(seats[: len(seats) // 2], reversed(seats))
        rounds.append([(min(pair), max(pair)) for pair in pairs if max(pair) < count])
        seats = [seats[0], seats[-1], *seats[1:-1]]
    return rounds


def _schedule() -> tuple[np.ndarray, np.ndarray]:
    """First and second rows of the pairs of 2 rows, of 3, and so on: those of m rows begin at m (m − 1) (m − 2)/6."""
    pairs = [pair for count in range(2, MOST_ROWS + 1) for each in _tournament(count) for pair in each]
    first, second = np.ascontiguousarray(np.transpose(pairs), dtype=np.int8)  # others would be taken by address
    return first, second


FIRST, SECOND = _schedule()


def dot(A: Pointer, i: int, j: int, width: Sizes) -> Number:
    """The dot product of rows i and j, summed in a fixed order; the width is a multiple of 8."""
    raise NotImplementedError


@overload(dot, strict=False)
def _dot(A: Any, i: Any, j: Any, width: Any) -> Any:
    def side_by_side(A: Pointer, i: int, j: int, width: Sizes) -> Number:
        P = len(width)
        a, b = i * P, j * P
        s0, s1, s2, s3 = A[a] * A[b], A[a + 1] * A[b + 1], A[a + 2] * A[b + 2], A[a + 3] * A[b + 3]
        s4, s5, s6, s7 = A[a + 4] * A[b + 4], A[a + 5] * A[b + 5], A[a + 6] * A[b + 6], A[a + 7] * A[b + 7]
        for c in range(8, P, 8):
            s0, s1 = s0 + A[a + c] * A[b + c], s1 + A[a + c + 1] * A[b + c + 1]
            s2, s3 = s2 + A[a + c + 2] * A[b + c + 2], s3 + A[a + c + 3] * A[b + c + 3]
            s4, s5 = s4 + A[a + c + 4] * A[b + c + 4], s5 + A[a + c + 5] * A[b + c + 5]
            s6, s7 = s6 + A[a + c + 6] * A[b + c + 6], s7 + A[a + c + 7] * A[b + c + 7]
        return ((s0 + s4) + (s2 + s6)) + ((s1 + s5) + (s3 + s7))

    def alone(A: Pointer, i: int, j: int, width: Sizes) -> Number:
        rows, P = by_eights(A), len(width) // 8
        total = rows[i * P] * rows[j * P]
        for c in range(1, P):
            total = total + rows[i * P + c] * rows[j * P + c]
        return folded(total)

    return side_by_side if A.dtype == LANES else alone


def turn(A: Pointer, i: int, j: int, c: Number, s: Number, width: Sizes) -> None:
    """Rotates rows i and j by the angle of cosine c and sine s."""
    raise NotImplementedError


@overload(turn, strict=False)
def _turn(A: Any, i: Any, j: Any, c: Any, s: Any, width: Any) -> Any:
    def one_by_one(A: Pointer, i: int, j: int, c: Number, s: Number, width: Sizes) -> None:
        P = len(width)
        for x in range(P):
            one, other = A[i * P + x], A[j * P + x]
            A[i * P + x] = c * one - s * other
            A[j * P + x] = s * one + c * other

    def by_row(A: Pointer, i: int, j: int, c: Number, s: Number, width: Sizes) -> None:
        rows, P = by_eights(A), len(width) // 8
        for x in range(P):
            one, other = rows[i * P + x], rows[j * P + x]
            rows[i * P + x] = c * one - s * other
            rows[j * P + x] = s * one + c * other

    return one_by_one if A.dtype == LANES or width.count % 8 else by_row


@called
def orthogonalise(
    A: Pointer, C: Pointer, m: int, width: Sizes, carried: Sizes, norms: Pointer, floor: float, zero: Number
) -> None:
    """Rotates the m rows of A until they are orthogonal, and those of C with them.

    A lane that is done stays as it is while the others go on.

    Args:
        A: m rows, entries of about 1 at the most.
        C: m rows of `carried` entries.
        m: At most MOST_ROWS.
        width: Length of the rows of A: a multiple of 4.
        carried: Length of the rows of C.
        norms: Room for m numbers; filled with the squared lengths of the rows.
        floor: Rows whose squared length is less than this part of the largest one's count as rounding errors and are
            not rotated; ALL to rotate all rows.
        zero: 0 of the kind of number that A holds.
    """
    first = m * (m - 1) * (m - 2) // 6
    pairs = m * (m - 1) // 2
    going = zero + 1.0
    for _ in range(SWEEPS):
        limit = zero
        for i in range(m):
            norms[i] = dot(A, i, i, width)
            limit = where(norms[i] > limit, norms[i], limit)
        limit = floor * limit
        worst = zero
        for pair in range(first, first + pairs):
            i, j = int(FIRST[pair]), int(SECOND[pair])
            # Rounding may make the rest of a row negative.
            g, a, b = dot(A, i, j, width), where(norms[i] > 0.0, norms[i], zero), where(norms[j] > 0.0, norms[j], zero)
            # Where squares could underflow, all are scaled up: rotations depend on ratios only.
            grown = where((a < SMALL) & (b < SMALL), zero + 1e150, zero + 1.0)
            grown = where((a < TINY) & (b < TINY), zero + 1e250, grown)
            x, d, both = g * grown, (b - a) * grown, (a * grown) * (b * grown)
            square = x * x
            moves = (square > ORTHOGONAL * both) & (both > 0.0) & (going > 0.0) & (where(a < b, a, b) >= limit)
            long = size(d)
            h = where(moves, root(d * d + 4.0 * square), zero + 1.0)
            tangent = where(moves, 2.0 * x / (long + h), zero)
            tangent = where(d >= 0.0, tangent, zero - tangent)
            c = where(moves, root(0.5 + 0.5 * (long / h)), zero + 1.0)
            s = tangent * c
            cosine = where(moves, square / both, zero)
            worst = where(cosine > worst, cosine, worst)
            worst = where(tangent * tangent > worst, tangent * tangent, worst)
            shift = tangent * g
            norms[i] = a - shift
            norms[j] = b + shift
            turn(A, i, j, c, s, width)
            turn(C, i, j, c, s, carried)
        going = where(worst > LAST, going, zero)
        if not somewhere(going > 0.0):
            break
    for i in range(m):
        norms[i] = dot(A, i, i, width)
