"""The compiled form of `inverses.second_order.weak_rows`, which has the reasons: splits J q̇ = ẋ at γσ₁."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, stack
from robust_ik.kernels.matrices.small_products import dot
from robust_ik.kernels.matrices.small_svd import decompose_some
from robust_ik.kernels.second_order import second_order_layout as lay


@inlined
def vector_of(sheet: Pointer, place: int, width: Sizes) -> Pointer:
    """A vector of the sheet."""
    return further(sheet, lay.HEAD + place * len(width))


@inlined
def matrix_of(sheet: Pointer, place: int, width: Sizes) -> Pointer:
    """A matrix of the sheet, row by row without gaps; BEND has room for one for each weak row."""
    return further(sheet, lay.HEAD + (lay.VECTORS + place * len(width)) * len(width))


@inlined
def motion_of(sheet: Pointer, index: int, n: int, width: Sizes) -> Pointer:
    """A kernel motion, (n,)."""
    return further(matrix_of(sheet, lay.RIGHT, width), (int(sheet[lay.KEPT]) + index) * n)


@called
def norm(x: Pointer, size: int) -> float:
    """‖x‖; 0 if the squares vanish."""
    return math.sqrt(dot(x, x, size))


@called
def largest_of(x: Pointer, size: int) -> float:
    """The largest |x|."""
    largest = 0.0
    for i in range(size):
        largest = max(largest, abs(x[i]))
    return largest


@inlined
def shortening(largest: float, most: float) -> float:
    """The factor that makes a largest number at most `most`."""
    return most / largest if largest > most else 1.0


@called
def upright(motion: Pointer, n: int) -> float:
    """±1, so that the largest joint of a motion, the first of those that are nearly as large, turns positive."""
    least = lay.NEARLY * largest_of(motion, n)
    for c in range(n):
        if abs(motion[c]) >= least:
            return 1.0 if motion[c] >= 0.0 else -1.0
    return 1.0


@inlined
def fade(fraction: float) -> float:
    """1 up to half of the threshold, 0 from the threshold on, with slope 0 at both."""
    t = min(max(2.0 * (1.0 - fraction), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


@called
def split_rows(
    parameters: Pointer, J: Pointer, x: Pointer, m: int, n: int, least: float, sheet: Pointer, width: Sizes
) -> bool:
    """Fills in what is known of the rows without ∂J/∂q; whether something is asked of weak rows.

    Args:
        parameters: See `second_order_layout`.
        J: (m, n), not zero.
        x: ẋ, (m,).
        m: Number of rows.
        n: Number of joints.
        least: Least σ₁ to compare with: 0, or that of a singular value beside those of J.
        sheet: Filled but for the quartic, bends and turning rates.
        width: At least m and n.
    """
    full = min(m, n)
    U, Vt = matrix_of(sheet, lay.LEFT, width), matrix_of(sheet, lay.RIGHT, width)
    s, asked = stack(0.0, ONE, width), stack(0.0, ONE, width)
    decompose_some(J, U, s, Vt, m, n, n, 1, width, width, 0.0)
    largest, r = max(s[0], least), 0
    for i in range(full):
        s[i] = s[i] / largest
        asked[i] = 0.0
        for row in range(m):
            asked[i] += U[row * full + i] * x[row]
        asked[i] /= largest
        r += s[i] >= parameters[lay.GAMMA]
    kept = vector_of(sheet, lay.KEPT_MOTION, width)
    for i in range(r):
        vector_of(sheet, lay.KEPT_SIGMA, width)[i] = s[i]
    for c in range(n):
        kept[c] = 0.0
        for i in range(r):
            kept[c] += Vt[i * n + c] * (asked[i] / s[i])
    sheet[lay.WEAK], sheet[lay.FREE], sheet[lay.KEPT] = float(full - r), float(n - r), float(r)
    sheet[lay.SIGMA_1] = largest
    return fade_rows(parameters[lay.GAMMA], further(s, r), further(asked, r), full - r, n - r, sheet, width)


@called
def fade_rows(gamma: float, s: Pointer, asked: Pointer, k: int, p: int, sheet: Pointer, width: Sizes) -> bool:
    """Fills in σ, command and fades of the k weak rows and p kernel motions; whether something is asked of them."""
    sigma, command = vector_of(sheet, lay.SIGMA, width), vector_of(sheet, lay.COMMAND, width)
    fades, reach = vector_of(sheet, lay.FADES, width), vector_of(sheet, lay.REACH, width)
    shorter, most, total = shortening(largest_of(asked, k), lay.LARGE), 0.0, 0.0
    for i in range(k):
        sigma[i], command[i] = s[i], asked[i] * shorter
        fades[i] = fade(s[i] / gamma)
        reach[i] = fades[i]
        most = max(most, fades[i])
        total += (fades[i] * command[i]) ** 2
    for j in range(k, p):
        reach[j] = most
    sheet[lay.FADE], sheet[lay.ASKED] = most, math.sqrt(total)
    return math.sqrt(total) > 0.0


@inlined
def left_of(sheet: Pointer, row: int, index: int, width: Sizes) -> float:
    """The entry in a row of the task of what is nearly lost, of the weak row `index`."""
    r = int(sheet[lay.KEPT])
    return float(matrix_of(sheet, lay.LEFT, width)[row * (r + int(sheet[lay.WEAK])) + r + index])


@called
def forms_of(H: Pointer, m: int, n: int, sheet: Pointer, forms: Pointer, width: Sizes) -> None:
    """Fills in uᵀ ∂J/∂q of each weak row u, (k, n, n), from ∂J/∂q, (m, n, n)."""
    for i in range(int(sheet[lay.WEAK])):
        for c in range(n * n):
            forms[i * n * n + c] = 0.0
        for row in range(m):
            share = left_of(sheet, row, i, width)
            for c in range(n * n):
                forms[i * n * n + c] += share * H[row * n * n + c]


@called
def bend_rows(forms: Pointer, n: int, sheet: Pointer, width: Sizes) -> None:
    """Fills in K, G and the turning rates.

    Args:
        forms: uᵀ ∂J/∂q of each weak row u, (k, n, n), of which the symmetric part counts; left with it alone.
        n: Number of joints.
        sheet: From `split_rows`.
        width: At least m and n.
    """
    k, p, r = int(sheet[lay.WEAK]), int(sheet[lay.FREE]), int(sheet[lay.KEPT])
    command, fades = vector_of(sheet, lay.COMMAND, width), vector_of(sheet, lay.FADES, width)
    reach, kept = vector_of(sheet, lay.REACH, width), vector_of(sheet, lay.KEPT_MOTION, width)
    Z, K = motion_of(sheet, 0, n, width), matrix_of(sheet, lay.BEND, width)
    G = matrix_of(sheet, lay.CROSS, width)
    along, lost = stack(0.0, width, width), stack(0.0, width, width)
    length, shorter, largest = norm(command, k), shortening(largest_of(kept, n), lay.LARGE), sheet[lay.SIGMA_1]
    factor = shortening(largest_of(forms, k * n * n), lay.LARGE * largest) / largest
    for i in range(p * n):
        lost[i] = 0.0
    for i in range(k):
        bent_along(further(forms, i * n * n), n, factor, sheet, along, width)
        for a in range(p):
            G[i * p + a] = dot(kept, further(along, a * n), n) * shorter * reach[a] * fades[i]
            for b in range(p):
                bend = dot(further(Z, a * n), further(along, b * n), n)
                K[(i * p + a) * p + b] = bend * (reach[a] * reach[b]) * fades[i]
        share = command[i] / length if length > 0.0 else command[i]
        for c in range(p * n):
            lost[c] += share * along[c]
    T, Vt = matrix_of(sheet, lay.TURNING, width), matrix_of(sheet, lay.RIGHT, width)
    kept_sigma = vector_of(sheet, lay.KEPT_SIGMA, width)
    for i in range(r):
        for a in range(p):
            T[i * p + a] = dot(further(Vt, i * n), further(lost, a * n), n) / kept_sigma[i]


@called
def bent_along(form: Pointer, n: int, factor: float, sheet: Pointer, along: Pointer, width: Sizes) -> None:
    """Fills in the symmetric part of a form, (n, n), times a factor and each kernel motion, (p, n)."""
    for a in range(n):
        for b in range(a + 1):
            half = 0.5 * factor * (form[a * n + b] + form[b * n + a])
            form[a * n + b], form[b * n + a] = half, half
    for j in range(int(sheet[lay.FREE])):
        for a in range(n):
            along[j * n + a] = dot(further(form, a * n), motion_of(sheet, j, n, width), n)
