"""Levenberg-Marquardt steps of many small systems, one after another."""

from __future__ import annotations

import math

from robust_ik.checks import Array
from robust_ik.kernels.compiler.compiling import FLOAT, filled, given, inlined, kernel

ROUNDING = 1e-15
"""Times the trace, added to μ: pivots are then more than rounding errors."""
TINY = 1e-300
"""Added to μ, so that a zero matrix has no zero pivots. Chosen: near the least normal double, 2e-308."""


@inlined
def factor(gram: Array, size: int, mu: float) -> None:
    """Factors gram + μI = L Lᵀ by Cholesky; L replaces the lower triangle.

    No pivot is less than μ except by rounding.
    """
    for i in range(size):
        for j in range(i + 1):
            total = gram[i, j]
            for t in range(j):
                total -= gram[i, t] * gram[j, t]
            gram[i, j] = math.sqrt(max(total + mu, mu)) if i == j else total / gram[j, j]


@inlined
def solve(gram: Array, size: int, x: Array) -> None:
    """Solves L Lᵀ y = x; y replaces x."""
    for i in range(size):
        for t in range(i):
            x[i] -= gram[i, t] * x[t]
        x[i] /= gram[i, i]
    for i in range(size - 1, -1, -1):
        for t in range(i + 1, size):
            x[i] -= gram[t, i] * x[t]
        x[i] /= gram[i, i]


@kernel(given(3), given(2), given(1), FLOAT, filled(2), filled(2), filled(2))
def steps(A: Array, weakest: Array, mu: Array, longest: float, gram: Array, room: Array, result: Array) -> None:
    """−(AᵀA + μI)⁻¹ Aᵀr of every system, scaled down so that no entry is more than `longest`.

    Args:
        A: (N, p, n), p = a b.
        weakest: (N, a): the residual r is an (a, b) matrix, row by row, with this diagonal and zeros elsewhere.
        mu: (N,).
        longest: More than 0.
        gram: Room, (k, k) for k = min(p, n).
        room: Room, (1, k).
        result: (N, n).
    """
    p, n = A.shape[1], A.shape[2]
    a = weakest.shape[1]
    stride, size, x = p // a + 1, min(p, n), room[0]
    for e in range(len(A)):
        J, trace = A[e], 0.0
        for i in range(size):
            x[i] = 0.0
            for j in range(i + 1):
                total = 0.0
                if p < n:
                    for t in range(n):
                        total += J[i, t] * J[j, t]
                else:
                    for t in range(p):
                        total += J[t, i] * J[t, j]
                gram[i, j] = total
            trace += gram[i, i]
        for i in range(a):
            if p < n:
                x[i * stride] = weakest[e, i]
            else:
                for j in range(n):
                    x[j] += J[i * stride, j] * weakest[e, i]
        factor(gram, size, mu[e] + ROUNDING * trace + TINY)
        solve(gram, size, x)
        most = longest
        for j in range(n):
            total = x[j] if p >= n else 0.0
            if p < n:
                for i in range(p):
                    total += J[i, j] * x[i]
            result[e, j] = total
            most = max(most, abs(total))
        for j in range(n):
            result[e, j] *= -longest / most
