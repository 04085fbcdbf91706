"""Levenberg-Marquardt steps of many small systems, one after another."""

from __future__ import annotations

import math

from robust_ik.checks import Array
from robust_ik.kernels.compiler.compiling import FLOAT, called, filled, given, inlined, kernel
from robust_ik.kernels.compiler.stack_memory import Pointer, further, pointer

ROUNDING = 1e-15
"""Times the trace, added to μ: pivots are then more than rounding errors."""
TINY = 1e-300
"""Added to μ, so that a zero matrix has no zero pivots. Chosen: near the least normal double, 2e-308."""


@inlined
def factor(gram: Pointer, size: int, mu: float) -> None:
    """Factors gram + μI = L Lᵀ by Cholesky; L replaces the lower triangle.

    No pivot is less than μ except by rounding.
    """
    for i in range(size):
        for j in range(i + 1):
            total = gram[i * size + j]
            for t in range(j):
                total -= gram[i * size + t] * gram[j * size + t]
            gram[i * size + j] = math.sqrt(max(total + mu, mu)) if i == j else total / gram[j * size + j]


@inlined
def solve(gram: Pointer, size: int, x: Pointer) -> None:
    """Solves L Lᵀ y = x; y replaces x."""
    for i in range(size):
        for t in range(i):
            x[i] -= gram[i * size + t] * x[t]
        x[i] /= gram[i * size + i]
    for i in range(size - 1, -1, -1):
        for t in range(i + 1, size):
            x[i] -= gram[t * size + i] * x[t]
        x[i] /= gram[i * size + i]


@called
def damped_step(
    J: Pointer, weakest: Pointer, p: int, n: int, a: int, mu: float, longest: float, gram: Pointer, x: Pointer,
    result: Pointer,
) -> None:  # fmt: skip
    """−(JᵀJ + μI)⁻¹ Jᵀr, scaled down so that no entry is more than `longest`.

    Args:
        J: (p, n), p = a b.
        weakest: (a,): the residual r is an (a, b) matrix, row by row, with this diagonal and zeros elsewhere.
        p: Rows of J.
        n: Its columns.
        a: Rows of the residual.
        mu: μ.
        longest: More than 0.
        gram: Room, (k, k) for k = min(p, n).
        x: Room, (k,).
        result: Filled, (n,).
    """
    stride, size, trace = p // a + 1, min(p, n), 0.0
    for i in range(size):
        x[i] = 0.0
        for j in range(i + 1):
            total = 0.0
            if p < n:
                for t in range(n):
                    total += J[i * n + t] * J[j * n + t]
            else:
                for t in range(p):
                    total += J[t * n + i] * J[t * n + j]
            gram[i * size + j] = total
        trace += gram[i * size + i]
    for i in range(a):
        if p < n:
            x[i * stride] = weakest[i]
        else:
            for j in range(n):
                x[j] += J[i * stride * n + j] * weakest[i]
    factor(gram, size, mu + ROUNDING * trace + TINY)
    solve(gram, size, x)
    most = longest
    for j in range(n):
        total = x[j] if p >= n else 0.0
        if p < n:
            for i in range(p):
                total += J[i * n + j] * x[i]
        result[j] = total
        most = max(most, abs(total))
    for j in range(n):
        result[j] *= -longest / most


@kernel(given(3), given(2), given(1), FLOAT, filled(2), filled(2), filled(2))
def steps(A: Array, weakest: Array, mu: Array, longest: float, gram: Array, room: Array, result: Array) -> None:
    """`damped_step` of every system: A (N, p, n), weakest (N, a), μ (N,), result (N, n)."""
    p, n, a = A.shape[1], A.shape[2], weakest.shape[1]
    for e in range(len(A)):
        damped_step(
            further(pointer(A), e * p * n), further(pointer(weakest), e * a), p, n, a, mu[e], longest,
            pointer(gram), pointer(room), further(pointer(result), e * n),
        )  # fmt: skip
