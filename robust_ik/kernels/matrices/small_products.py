"""Products of vectors, and of small matrices that lie row by row."""

from __future__ import annotations

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import Pointer


@called
def dot(a: Pointer, b: Pointer, size: int) -> float:
    """Σ aᵢ bᵢ."""
    total = 0.0
    for i in range(size):
        total += a[i] * b[i]
    return total


@called
def multiply(A: Pointer, rows: int, inner: int, B: Pointer, columns: int, to: Pointer) -> None:
    """Fills in A B, (rows, columns), from (rows, inner) and (inner, columns); `to` is neither of them."""
    for i in range(rows):
        for k in range(columns):
            total = 0.0
            for j in range(inner):
                total += A[i * inner + j] * B[j * columns + k]
            to[i * columns + k] = total


@called
def multiply_transposed(A: Pointer, inner: int, rows: int, B: Pointer, columns: int, to: Pointer) -> None:
    """Fills in Aᵀ B, (rows, columns), from (inner, rows) and (inner, columns); `to` is neither of them."""
    for i in range(rows):
        for k in range(columns):
            total = 0.0
            for j in range(inner):
                total += A[j * rows + i] * B[j * columns + k]
            to[i * columns + k] = total
