"""Joint velocities from J and ẋ: by Cholesky factors, or by orthogonal rows and a gain formula of their lengths."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import inlined
from robust_ik.kernels.compiler.simd_lanes import Number, root
from robust_ik.kernels.compiler.stack_memory import ONE, W8, Pointer, Sizes, call_gain, further, stack
from robust_ik.kernels.matrices.jacobi_rotations import dot
from robust_ik.kernels.step import step_layout as slots

ROUNDING = 1e-32
"""Squared length of a row, relative to the longest row's, below which it is rounding error."""
WELL_DAMPED = 1e-8
"""λ² as a fraction of the trace of JJᵀ above which squaring J costs no significant digits."""


@inlined
def damped(J: Pointer, x: Pointer, m: int, squared: float, out: Pointer, width: Sizes, zero: Number) -> Number:
    """Fills out with Jᵀ (JJᵀ + λ²I)⁻¹ ẋ by Cholesky factors; returns the trace of JJᵀ."""
    G, y = stack(zero, W8, W8), stack(zero, ONE, W8)
    trace = zero
    for i in range(m):
        for j in range(i + 1):
            g = dot(J, i, j, width)
            if i == j:
                trace = trace + g
                g = g + squared
            for c in range(j):
                g = g - G[i * 8 + c] * G[j * 8 + c]
            G[i * 8 + j] = 1.0 / root(g) if i == j else g * G[j * 8 + j]
        value = x[i]
        for c in range(i):
            value = value - G[i * 8 + c] * y[c]
        y[i] = value * G[i * 8 + i]
    for back in range(m):
        i = m - 1 - back
        value = y[i]
        for c in range(i + 1, m):
            value = value - G[c * 8 + i] * y[c]
        y[i] = value * G[i * 8 + i]
    combine(J, y, m, out, width, zero)
    return trace


@inlined
def combine(rows: Pointer, y: Pointer, m: int, out: Pointer, width: Sizes, zero: Number) -> None:
    """Fills out with Σ yᵢ rowᵢ."""
    P = len(width)
    for c in range(P):
        out[c] = y[0] * rows[c]
    for i in range(1, m):
        for c in range(P):
            out[c] = out[c] + y[i] * rows[i * P + c]


@inlined
def order_of(squares: Pointer, order: Pointer, m: int, lane: int, lanes: int) -> None:
    """Fills the order of the rows of one lane, the longest first."""
    for i in range(m):
        place_ = i
        while place_ > 0 and squares[int(order[place_ - 1]) * lanes + lane] < squares[i * lanes + lane]:
            order[place_] = order[place_ - 1]
            place_ -= 1
        order[place_] = i


@inlined
def weigh(program: Pointer, squares: Pointer, x: Pointer, y: Pointer, m: int, k: int, lane: int, lanes: int) -> None:
    """Fills y with φ(σᵢ)/σᵢ uᵢᵀẋ for the k longest rows of one lane, by the gain formula, and 0 for the others."""
    order, parameters = stack(0.0, ONE, W8), further(program, int(program[slots.PARAMETERS]))
    order_of(squares, order, m, lane, lanes)
    product = 1.0
    for index in range(k):
        product *= math.sqrt(squares[int(order[index]) * lanes + lane])
    largest = math.sqrt(squares[int(order[0]) * lanes + lane])
    smallest = math.sqrt(squares[int(order[k - 1]) * lanes + lane])
    product = product if smallest > 0.0 else 0.0
    address = int(program[slots.ADDRESS])
    for index in range(m):
        i = int(order[index]) * lanes + lane
        sigma = math.sqrt(squares[i])
        if index < k and sigma > 0.0:
            gain = call_gain(address, (sigma, largest, smallest, product, float(k - 1 - index), parameters))
            y[i] = gain / sigma * x[i]
        else:
            y[i] = 0.0


@inlined
def add_beside(J: Pointer, squares: Pointer, m: int, k: int, beside: Pointer, out: Pointer, width: Sizes) -> None:
    """Adds the part of a secondary joint velocity that is orthogonal to the k longest rows of an orthogonal J."""
    P, order = len(width), stack(0.0, ONE, W8)
    rest = further(J, m * P)
    order_of(squares, order, m, 0, 1)
    for c in range(P):
        rest[c] = beside[c]
    for index in range(k):
        i = int(order[index])
        if squares[i] > 0.0:
            share = dot(J, i, m, width) / squares[i]
            for c in range(P):
                rest[c] -= share * J[i * P + c]
    for c in range(P):
        out[c] += rest[c]
