"""Eigenvalues and eigenvectors of small symmetric matrices, by rotations.

Source: Jacobi 1846; the rotation of Golub and Van Loan, Matrix Computations, section 8.5.2.
"""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import Pointer

SWEEPS = 30
"""Most sweeps. Chosen: random matrices of 16 rows take up to 11."""
ROUNDING = 1e-17
"""Entries of at most this part of the largest one count as zero. Chosen: below ε/16, what rounding makes of a sum."""


@called
def diagonalise(A: Pointer, size: int, values: Pointer, vectors: Pointer) -> None:
    """Fills in eigenvalues, in no order, and orthonormal eigenvectors.

    Args:
        A: Symmetric, (size, size); destroyed.
        size: At least 1.
        values: (size,), filled.
        vectors: (size, size), filled: row i belongs to value i.
    """
    largest = 0.0
    for i in range(size):
        for j in range(size):
            vectors[i * size + j] = 1.0 if i == j else 0.0
            largest = max(largest, abs(A[i * size + j]))
    least = ROUNDING * largest
    for _ in range(SWEEPS):
        still = True
        for i in range(size):
            for j in range(i + 1, size):
                if abs(A[i * size + j]) > least:
                    rotate(A, size, i, j, vectors)
                    still = False
        if still:
            break
    for i in range(size):
        values[i] = A[i * size + i]


@called
def rotate(A: Pointer, size: int, i: int, j: int, vectors: Pointer) -> None:
    """Rotates rows and columns i and j of A, whose common entry is not 0, so that it vanishes, and rows of vectors."""
    x, a, b = A[i * size + j], A[i * size + i], A[j * size + j]
    ratio = 0.5 * (b - a) / x
    t = math.copysign(1.0, ratio) / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
    c = 1.0 / math.sqrt(1.0 + t * t)
    s = t * c
    for k in range(size):
        one, other = A[i * size + k], A[j * size + k]
        A[i * size + k], A[j * size + k] = c * one - s * other, s * one + c * other
        one, other = vectors[i * size + k], vectors[j * size + k]
        vectors[i * size + k], vectors[j * size + k] = c * one - s * other, s * one + c * other
    for k in range(size):
        A[k * size + i], A[k * size + j] = A[i * size + k], A[j * size + k]
    A[i * size + i], A[j * size + j] = a - t * x, b + t * x
    A[i * size + j], A[j * size + i] = 0.0, 0.0
