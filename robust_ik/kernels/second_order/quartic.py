"""The compiled form of `inverses.second_order.weak_motion.Quartic`, f(z) = ½‖Dz + τ/2 K[z, z] − c‖² + ½ zᵀ diag(μ) z.

On the sheet, K is τ times the curvature once the quartic is made.
"""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, stack
from robust_ik.kernels.matrices.definite_systems import factor_definite, solve_factored
from robust_ik.kernels.matrices.small_products import dot
from robust_ik.kernels.matrices.symmetric_eigenvectors import diagonalise
from robust_ik.kernels.second_order import second_order_layout as lay
from robust_ik.kernels.second_order.weak_rows import largest_of, matrix_of, norm, vector_of


@called
def add_combined(K: Pointer, weights: Pointer, factor: float, k: int, p: int, to: Pointer) -> None:
    """Adds factor · Σ wᵢKᵢ, (p, p)."""
    for i in range(k):
        share = factor * weights[i]
        for x in range(p * p):
            to[x] += share * K[i * p * p + x]


@called
def largest_eigenvalue(A: Pointer, size: int, width: Sizes) -> float:
    """The largest |eigenvalue| of a symmetric matrix, which is destroyed; 0 without rows."""
    values, vectors = stack(0.0, ONE, width), stack(0.0, width, width)
    diagonalise(A, size, values, vectors)
    return largest_of(values, size)


@called
def spectral_norm(D: Pointer, k: int, p: int, width: Sizes) -> float:
    """The largest singular value of D, (k, p)."""
    square = stack(0.0, width, width)
    for i in range(k):
        for j in range(k):
            square[i * k + j] = dot(further(D, i * p), further(D, j * p), p)
    return math.sqrt(largest_eigenvalue(square, k, width))


@called
def make_quartic(parameters: Pointer, sheet: Pointer, width: Sizes) -> None:
    """Fills in D, K, c and μ of f, τ and κ; see `weak_motion.quartic`."""
    k, p, fade = int(sheet[lay.WEAK]), int(sheet[lay.FREE]), sheet[lay.FADE]
    speed, acceleration = parameters[lay.SPEED], parameters[lay.ACCELERATION]
    command, fades = vector_of(sheet, lay.COMMAND, width), vector_of(sheet, lay.FADES, width)
    D, K, pull = matrix_of(sheet, lay.SLOPE, width), matrix_of(sheet, lay.BEND, width), stack(0.0, width, width)
    size = sheet[lay.ASKED] + lay.TINY
    for x in range(p * p):
        pull[x] = 0.0
    add_combined(K, command, 1.0, k, p, pull)
    curvature = largest_eigenvalue(pull, p, width) / size
    kappa = max(curvature, lay.STIFF)
    wanted = max((2.0 * size / (kappa * acceleration**2)) ** (1.0 / 3.0), 2.0 * size / (kappa * speed**2))
    tau = min(max(wanted, lay.SHORTEST, lay.STEPS * parameters[lay.DT]), parameters[lay.HORIZON])
    for i in range(k):
        for a in range(p):
            D[i * p + a] = tau * matrix_of(sheet, lay.CROSS, width)[i * p + a]
        D[i * p + i] += vector_of(sheet, lay.SIGMA, width)[i]
    for x in range(k * p * p):
        K[x] *= tau
    possible = spectral_norm(D, k, p, width) * speed + 0.5 * tau * curvature * speed**2
    bent = min(max((curvature / lay.FLAT - lay.LITTLE) / (1.0 - lay.LITTLE), 0.0), 1.0)
    cut = bent * max(0.0, 1.0 - possible / size)
    size *= 1.0 - fade * cut
    squared = lay.FLOOR**2 + max(0.0, (size / (2.0 * speed)) ** 2 - lay.BENT * size * curvature * tau)
    wish, mu = vector_of(sheet, lay.WANTED, width), vector_of(sheet, lay.MU, width)
    for i in range(k):
        wish[i], mu[i] = (1.0 - fades[i] * cut) * command[i], squared * fades[i]
    for j in range(k, p):
        mu[j] = squared * max(fade, lay.LEAST_FADE)
    sheet[lay.LOOK_AHEAD], sheet[lay.CURVATURE] = tau, curvature


@called
def bend_along(sheet: Pointer, z: Pointer, bent: Pointer, width: Sizes) -> None:
    """Fills in K z, (k, p)."""
    k, p, K = int(sheet[lay.WEAK]), int(sheet[lay.FREE]), matrix_of(sheet, lay.BEND, width)
    for x in range(k * p):
        total = 0.0
        for b in range(p):
            total += K[x * p + b] * z[b]
        bent[x] = total


@called
def served_by(sheet: Pointer, z: Pointer, bent: Pointer, served: Pointer, width: Sizes) -> None:
    """Fills in D z + ½ (K z) z, (k,), from K z."""
    k, p, D = int(sheet[lay.WEAK]), int(sheet[lay.FREE]), matrix_of(sheet, lay.SLOPE, width)
    for i in range(k):
        served[i] = 0.0
        for a in range(p):
            served[i] += (D[i * p + a] + 0.5 * bent[i * p + a]) * z[a]


@inlined
def cost(sheet: Pointer, z: Pointer, rest: Pointer, width: Sizes) -> float:
    """½‖rest‖² + ½ zᵀ diag(μ) z."""
    mu, total = vector_of(sheet, lay.MU, width), 0.0
    for a in range(int(sheet[lay.FREE])):
        total += z[a] * (mu[a] * z[a])
    return 0.5 * dot(rest, rest, int(sheet[lay.WEAK])) + 0.5 * total


@called
def residual(sheet: Pointer, z: Pointer, bent: Pointer, rest: Pointer, width: Sizes) -> None:
    """Fills in K z, (k, p), and c − Dz − τ/2 K[z, z], (k,)."""
    wish = vector_of(sheet, lay.WANTED, width)
    bend_along(sheet, z, bent, width)
    served_by(sheet, z, bent, rest, width)
    for i in range(int(sheet[lay.WEAK])):
        rest[i] = wish[i] - rest[i]


@called
def second_derivative(sheet: Pointer, slope: Pointer, rest: Pointer, A: Pointer, width: Sizes) -> None:
    """Fills in slopeᵀ slope − Σ restᵢKᵢ + diag(μ), (p, p), for slope = D + K z."""
    k, p, mu = int(sheet[lay.WEAK]), int(sheet[lay.FREE]), vector_of(sheet, lay.MU, width)
    for a in range(p):
        for b in range(p):
            total = mu[a] if a == b else 0.0
            for i in range(k):
                total += slope[i * p + a] * slope[i * p + b]
            A[a * p + b] = total
    add_combined(matrix_of(sheet, lay.BEND, width), rest, -1.0, k, p, A)


@called
def damped_start(sheet: Pointer, z: Pointer, width: Sizes) -> None:
    """Fills in the minimum without curvature: least ‖[diag √μ; D] z − [0; c]‖, by rotations of each row of D into R.

    Source: Givens 1958; Golub and Van Loan, Matrix Computations, section 5.2.5.
    """
    k, p, R, row = int(sheet[lay.WEAK]), int(sheet[lay.FREE]), stack(0.0, width, width), stack(0.0, ONE, width)
    for a in range(p):
        for b in range(p):
            R[a * p + b] = math.sqrt(vector_of(sheet, lay.MU, width)[a]) if a == b else 0.0
        z[a] = 0.0
    for i in range(k):
        for a in range(p):
            row[a] = matrix_of(sheet, lay.SLOPE, width)[i * p + a]
        right = vector_of(sheet, lay.WANTED, width)[i]
        for a in range(p):
            size = math.sqrt(R[a * p + a] * R[a * p + a] + row[a] * row[a])
            if size > 0.0:
                cosine, sine = R[a * p + a] / size, row[a] / size
                for b in range(a, p):
                    one, other = R[a * p + b], row[b]
                    R[a * p + b], row[b] = cosine * one + sine * other, cosine * other - sine * one
                one = z[a]
                z[a], right = cosine * one + sine * right, cosine * right - sine * one
    for a in range(p - 1, -1, -1):
        for b in range(a + 1, p):
            z[a] -= R[a * p + b] * z[b]
        z[a] = z[a] / R[a * p + a] if R[a * p + a] > 0.0 else 0.0


@called
def descend(sheet: Pointer, z: Pointer, width: Sizes) -> float:
    """Moves z to a minimum of f near it, and returns f there; see `weak_motion.Quartic.descended`."""
    k, p = int(sheet[lay.WEAK]), int(sheet[lay.FREE])
    D, mu = matrix_of(sheet, lay.SLOPE, width), vector_of(sheet, lay.MU, width)
    bent, rest, gradient = stack(0.0, width, width), stack(0.0, ONE, width), stack(0.0, ONE, width)
    slope, A = stack(0.0, width, width), stack(0.0, width, width)
    enough = lay.ENOUGH * (norm(vector_of(sheet, lay.WANTED, width), k) + 1e-12)
    least = mu[0]
    for a in range(1, p):
        least = min(least, mu[a])
    least, damping = 0.5 * least + 1e-12, 0.0
    residual(sheet, z, bent, rest, width)
    found = cost(sheet, z, rest, width)
    for _ in range(lay.ROUNDS):
        for x in range(k * p):
            slope[x] = D[x] + bent[x]
        for a in range(p):
            gradient[a] = mu[a] * z[a]
            for i in range(k):
                gradient[a] -= rest[i] * slope[i * p + a]
        if largest_of(gradient, p) < enough:
            break
        second_derivative(sheet, slope, rest, A, width)
        lower, damping = fall(sheet, z, bent, rest, found, gradient, A, least, damping, width)
        if not lower < found:
            break
        found, damping = lower, 0.25 * damping if damping > 4e-9 else 0.0
    return found


@called
def fall(
    sheet: Pointer, z: Pointer, bent: Pointer, rest: Pointer, before: float, gradient: Pointer, A: Pointer,
    least: float, damping: float, width: Sizes,
) -> tuple[float, float]:  # fmt: skip
    """Moves z by a Newton step, damped until f falls below `before`; f there, and the damping.

    Where no eigenvalue is below `least`, factors give the step sooner than eigenvectors.

    Args:
        sheet: With the quartic.
        z: (p,), moved.
        bent: K z, moved on with it.
        rest: What of c is left, (k,), moved on with it.
        before: f(z).
        gradient: (p,).
        A: The second derivative, (p, p), of whose eigenvalues the sizes are taken, at least `least`; destroyed.
        least: See `A`.
        damping: To begin with.
        width: At least p.
    """
    p, step, L = int(sheet[lay.FREE]), stack(0.0, ONE, width), stack(0.0, width, width)
    if factor_definite(A, p, -least, L) and factor_definite(A, p, damping, L):
        for a in range(p):
            step[a] = gradient[a]
        solve_factored(L, p, step)
        lower = tried(sheet, z, step, bent, rest, before, width)
        if lower < before:
            return lower, damping
    values, vectors, highest = stack(0.0, ONE, width), stack(0.0, width, width), 0
    diagonalise(A, p, values, vectors)
    for i in range(p):
        highest = i if values[i] > values[highest] else highest
    stiffest = max(abs(values[highest]), least)
    for _ in range(lay.TRIES):
        for a in range(p):
            step[a] = 0.0
        for i in range(p):
            share = dot(further(vectors, i * p), gradient, p) / (max(abs(values[i]), least) + damping)
            for a in range(p):
                step[a] += share * vectors[i * p + a]
        lower = tried(sheet, z, step, bent, rest, before, width)
        if lower < before:
            return lower, damping
        damping = max(4.0 * damping, 1e-3 * stiffest)
    return before, damping


@called
def tried(
    sheet: Pointer, z: Pointer, step: Pointer, bent: Pointer, rest: Pointer, before: float, width: Sizes
) -> float:
    """The value of f at z − step; if it is below `before`, z moves there, with K z and what is left of c."""
    k, p, there = int(sheet[lay.WEAK]), int(sheet[lay.FREE]), stack(0.0, ONE, width)
    bent_there, rest_there = stack(0.0, width, width), stack(0.0, ONE, width)
    for a in range(p):
        there[a] = z[a] - step[a]
    residual(sheet, there, bent_there, rest_there, width)
    lower = cost(sheet, there, rest_there, width)
    if lower < before:
        for a in range(p):
            z[a] = there[a]
        for x in range(k * p):
            bent[x] = bent_there[x]
        for i in range(k):
            rest[i] = rest_there[i]
    return lower
