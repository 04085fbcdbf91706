"""Householder reflections that move differences in scale from the columns of a matrix to its rows.

One-sided Jacobi on rows finds every σ to its last bits if only the rows are scaled. If the columns are scaled, the
matrix is made triangular first: the rows of R in J = Q R then have the scales that the columns had.

Source: Drmač and Veselić 2008, with rows and columns pivoted as in Cox and Higham 1998.
"""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.simd_lanes import Number, where
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, by_eights, stack

UNEVEN = 30.0
"""Ratio of the largest entries of two columns above which the columns count as scaled."""

SMALL = 1e-200
"""Squared length below which the rest of a matrix is scaled up, since products of its entries may underflow."""


@called
def unevenness(J: Pointer, m: int, n: int, along_columns: bool) -> Number:
    """More than 0 if the columns of J, (m, n), else its rows, are of very different sizes; zero ones do not count."""
    outer, inner = (n, m) if along_columns else (m, n)
    least, most = math.inf, 0.0
    for c in range(outer):
        largest = 0.0
        for r in range(inner):
            largest = max(largest, abs(J[r * n + c] if along_columns else J[c * n + r]))
        least, most = where(largest > 0.0, min(least, largest), least), max(most, largest)
    return most - UNEVEN * least


@called
def triangulate(A: Pointer, C: Pointer, k: int, n: int, width: Sizes, carried: Sizes) -> None:
    """Reflects the k rows of A, n entries long, and of C, until A is triangular up to a permutation of its columns."""
    P, v, free = len(width), stack(0.0, ONE, width), stack(0.0, ONE, width)
    for c in range(n):
        free[c] = 1.0
    grown = 1.0
    for i in range(k - 1):
        best, most = longest(A, free, grown, i, k, n, width)
        if most < SMALL:
            grown = enlargement(A, free, i, k, n, width)
            best, most = longest(A, free, grown, i, k, n, width)
        if best < 0:
            return
        free[best] = 0.0
        top = i
        for r in range(i, k):
            if abs(A[r * P + best]) > abs(A[top * P + best]):
                top = r
        swap(A, i, top, width)
        swap(C, i, top, carried)
        pivot, square = A[i * P + best], 0.0
        for r in range(i, k):
            v[r] = A[r * P + best] * grown
        v[i] += math.copysign(math.sqrt(most), pivot)
        for r in range(i, k):
            square += v[r] * v[r]
        reflect(A, v, 2.0 / square, i, k, width)
        reflect(C, v, 2.0 / square, i, k, carried)
        for r in range(i + 1, k):
            A[r * P + best] = 0.0


@inlined
def longest(A: Pointer, free: Pointer, grown: float, i: int, k: int, n: int, width: Sizes) -> tuple[int, float]:
    """The free column that is longest from row i on, or −1 if all are zero; its squared length times `grown`²."""
    P, best, most = len(width), -1, 0.0
    for c in range(n):
        total = 0.0
        for r in range(i, k):
            entry = A[r * P + c] * grown
            total += entry * entry
        if free[c] > 0.0 and total > most:
            best, most = c, total
    return best, most


@called
def enlargement(A: Pointer, free: Pointer, i: int, k: int, n: int, width: Sizes) -> float:
    """The power of two that scales the free columns' largest entry from row i on to about 1, against underflow."""
    P, largest = len(width), 0.0
    for c in range(n):
        for r in range(i, k):
            largest = max(largest, abs(A[r * P + c]) * free[c])
    return math.ldexp(1.0, -max(math.frexp(largest)[1], -1000)) if largest > 0.0 else 1.0


@inlined
def swap(A: Pointer, i: int, j: int, width: Sizes) -> None:
    """Exchanges rows i and j."""
    rows, P = by_eights(A), len(width) // 8
    for x in range(P):
        one, other = rows[i * P + x], rows[j * P + x]
        rows[i * P + x], rows[j * P + x] = other, one


@inlined
def reflect(A: Pointer, v: Pointer, factor: float, begin: int, end: int, width: Sizes) -> None:
    """Subtracts factor vᵣ Σ vₛ row s from each row r; r and s run from `begin` to before `end`."""
    rows, P = by_eights(A), len(width) // 8
    for x in range(P):
        total = v[begin] * rows[begin * P + x]
        for r in range(begin + 1, end):
            total = total + v[r] * rows[r * P + x]
        for r in range(begin, end):
            rows[r * P + x] = rows[r * P + x] - (factor * v[r]) * total
