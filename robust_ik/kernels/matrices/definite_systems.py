"""Small symmetric systems whose matrix is found to be positive definite, or not, on the way."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import Pointer


@called
def factor_definite(A: Pointer, size: int, shift: float, L: Pointer) -> bool:
    """Fills in L, A + shift I = L Lᵀ, by Cholesky: its lower triangle, and on the diagonal the inverses of the pivots.

    False if A + shift I is not positive definite.
    """
    for i in range(size):
        for j in range(i + 1):
            total = A[i * size + j] + (shift if i == j else 0.0)
            for t in range(j):
                total -= L[i * size + t] * L[j * size + t]
            if i > j:
                L[i * size + j] = total * L[j * size + j]
            elif total > 0.0:
                L[i * size + i] = 1.0 / math.sqrt(total)
            else:
                return False
    return True


@called
def solve_factored(L: Pointer, size: int, x: Pointer) -> None:
    """Solves (A + shift I) y = x with L of `factor_definite`; y replaces x."""
    for i in range(size):
        for t in range(i):
            x[i] -= L[i * size + t] * x[t]
        x[i] *= L[i * size + i]
    for i in range(size - 1, -1, -1):
        for t in range(i + 1, size):
            x[i] -= L[t * size + i] * x[t]
        x[i] *= L[i * size + i]
