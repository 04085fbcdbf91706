"""Four equations linear in one variable u = (c, s) and in y: (c A + s B) y = 0, with y = v ⊗ w for two further ones.

The determinant of c A + s B is a form of degree 4 in u, a trigonometric polynomial of degree 2 in the angle of u.
"""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, sizes, stack

FOUR, SIXTEEN, FIVE = sizes(4), sizes(16), sizes(5)
ROUNDING = 2e-15
"""Rounding of a determinant over the product of its rows' lengths. Chosen: some ten ε."""


@called
def determinant(A: Pointer, n: int) -> tuple[float, float]:
    """The determinant of A, (n, n), which is destroyed, and a bound of its rounding. Partial pivots.

    Source of the bound: Hadamard 1893, |det A| ≤ Π ‖rows‖; rounding of entries changes it by that times a few ε.
    """
    result, size = 1.0, ROUNDING
    for i in range(n):
        square = 0.0
        for j in range(n):
            square += A[i * n + j] * A[i * n + j]
        size *= math.sqrt(square)
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(A[i * n + k]) > abs(A[best * n + k]):
                best = i
        pivot = A[best * n + k]
        if pivot == 0.0:
            return 0.0, size
        if best != k:
            result = -result
            for j in range(k, n):
                A[k * n + j], A[best * n + j] = A[best * n + j], A[k * n + j]
        result *= pivot
        for i in range(k + 1, n):
            factor = A[i * n + k] / pivot
            for j in range(k + 1, n):
                A[i * n + j] -= factor * A[k * n + j]
    return result, size


@called
def null_space(A: Pointer, flat: float, basis: Pointer) -> int:
    """Fills in up to four vectors that span the null space of A, (4, 4), at its weakest; returns how many.

    A is destroyed. Complete pivots; the last pivot counts as zero, others where they are below `flat` of the first.
    """
    columns, pivots = stack(0.0, ONE, FOUR), stack(0.0, ONE, FOUR)
    for j in range(4):
        columns[j] = float(j)
    rank = 3
    for k in range(3):
        row, column, largest = k, k, -1.0
        for i in range(k, 4):
            for j in range(k, 4):
                if abs(A[4 * i + j]) > largest:
                    row, column, largest = i, j, abs(A[4 * i + j])
        if (not largest > flat * pivots[0] and k > 0) or largest == 0.0:
            rank = k
            break
        pivots[k] = largest
        for j in range(4):
            A[4 * k + j], A[4 * row + j] = A[4 * row + j], A[4 * k + j]
        for i in range(4):
            A[4 * i + k], A[4 * i + column] = A[4 * i + column], A[4 * i + k]
        columns[k], columns[column] = columns[column], columns[k]
        for i in range(k + 1, 4):
            factor = A[4 * i + k] / A[4 * k + k]
            for j in range(k, 4):
                A[4 * i + j] -= factor * A[4 * k + j]
    for free in range(rank, 4):
        y = stack(0.0, ONE, FOUR)
        for i in range(4):
            y[i] = 0.0
        y[free] = 1.0
        for i in range(rank - 1, -1, -1):
            total = A[4 * i + free]
            for j in range(i + 1, rank):
                total += A[4 * i + j] * y[j]
            y[i] = -total / A[4 * i + i]
        size = 0.0
        for i in range(4):
            size += y[i] * y[i]
        size = math.sqrt(size)
        for i in range(4):
            basis[4 * (free - rank) + int(columns[i])] = y[i] / size
    return 4 - rank


@inlined
def twisted(y: Pointer) -> float:
    """How far y = (v₀w₀, v₀w₁, v₁w₀, v₁w₁), of length 1, is from a product: y₀y₃ − y₁y₂."""
    return float(y[0] * y[3] - y[1] * y[2])


@called
def factors(y: Pointer, v: Pointer, w: Pointer) -> None:
    """Fills in v and w, of length 1, of the product v ⊗ w next to y: the larger row and the larger column."""
    i = 0 if y[0] * y[0] + y[1] * y[1] >= y[2] * y[2] + y[3] * y[3] else 1
    w[0], w[1] = y[2 * i], y[2 * i + 1]
    size = math.sqrt(w[0] * w[0] + w[1] * w[1])
    w[0], w[1] = (w[0] / size, w[1] / size) if size > 0.0 else (1.0, 0.0)
    v[0], v[1] = y[0] * w[0] + y[1] * w[1], y[2] * w[0] + y[3] * w[1]
    size = math.sqrt(v[0] * v[0] + v[1] * v[1])
    v[0], v[1] = (v[0] / size, v[1] / size) if size > 0.0 else (1.0, 0.0)


@called
def quadratic_form_roots(a: float, b: float, c: float, roots: Pointer, near: float, flat: float) -> int:
    """Fills in up to two (x, y) of length 1 with a x² + b x y + c y² = 0; returns how many, −1 if all are.

    Two that are complex give their real part if the discriminant, with coefficients of size 1, is above −near − flat/s,
    s being the largest coefficient. All are where s is not above `flat`.
    """
    scale = max(abs(a), abs(b), abs(c))
    if not scale > flat:
        return -1
    a, b, c = a / scale, b / scale, c / scale
    inside = b * b - 4.0 * a * c
    if inside < -(near + flat / scale):
        return 0
    root = math.sqrt(max(inside, 0.0))
    h = -0.5 * (b + math.copysign(root, b))
    count = 2
    # x/y = h/a and c/h
    roots[0], roots[1] = h, a
    roots[2], roots[3] = c, h
    if h == 0.0:  # b = 0 and a c = 0
        roots[0], roots[1] = (1.0, 0.0) if a == 0.0 else (0.0, 1.0)
        count = 1
    for k in range(count):
        size = math.sqrt(roots[2 * k] ** 2 + roots[2 * k + 1] ** 2)
        roots[2 * k], roots[2 * k + 1] = roots[2 * k] / size, roots[2 * k + 1] / size
    return count
