"""Sine and cosine of many angles at once, by polynomials: the same bits on every processor.

Source: the minimax polynomials and the split π/2 of FreeBSD's msun (k_sin.c, k_cos.c, e_rem_pio2.c): under 1 ulp.
"""

from __future__ import annotations

import math
from typing import Any

from numba.extending import overload

from robust_ik.kernels.compiler.compiling import inlined
from robust_ik.kernels.compiler.simd_lanes import LANES, Number, where
from robust_ik.kernels.compiler.stack_memory import Pointer, by_eights

LARGEST = 1e5
"""Angles beyond this are first brought into [−π, π]. Up to 2²⁰ π/2 the products of FIRST and SECOND are exact."""
ROUNDING = 6755399441055744.0
"""1.5 · 2⁵²: adding and subtracting it rounds to a whole number."""
QUARTERS = 2 / math.pi
"""Quarter turns per radian."""
FIRST, SECOND, THIRD = 1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624879595063154e-21
"""π/2 in three parts: its first 33 bits, the next 33, the rest. pio2_1, pio2_2 and pio2_2t of e_rem_pio2.c."""
S1, S2, S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
S4, S5, S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
"""S1 to S6: sin x ≈ x + S1 x³ + … + S6 x¹³ for |x| ≤ π/4, a minimax polynomial; k_sin.c, error below 2⁻⁵⁸."""
C1, C2, C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
C4, C5, C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11
"""C1 to C6: cos x ≈ 1 − x²/2 + C1 x⁴ + … + C6 x¹⁴ for |x| ≤ π/4, a minimax polynomial; k_cos.c, error below 2⁻⁵⁸."""


@inlined
def near(angle: float) -> float:
    """The angle, or one of the same direction that is small enough for `cosine_and_sine`."""
    return angle if abs(angle) <= LARGEST else math.atan2(math.sin(angle), math.cos(angle))


@inlined
def cosine_and_sine(angle: Number) -> tuple[Number, Number]:
    """Cosine and sine of an angle of at most LARGEST."""
    turns = (angle * QUARTERS + ROUNDING) - ROUNDING
    x = ((angle - turns * FIRST) - turns * SECOND) - turns * THIRD
    z = x * x
    sine = x + z * x * (S1 + z * (S2 + z * (S3 + z * (S4 + z * (S5 + z * S6)))))
    half = 0.5 * z
    rest = 1.0 - half
    tail = z * z * (C1 + z * (C2 + z * (C3 + z * (C4 + z * (C5 + z * C6)))))
    cosine = rest + (((1.0 - rest) - half) + tail)
    # turns modulo 4, as −2, −1, 0, 1 or 2.
    quarter = turns - 4.0 * ((turns * 0.25 + ROUNDING) - ROUNDING)
    square = quarter * quarter
    odd = (square > 0.5) & (square < 2.0)
    c, s = where(odd, sine, cosine), where(odd, cosine, sine)
    c = where((quarter > 0.5) & (quarter < 1.5), 0.0 - c, c)
    c = where(square > 2.0, 0.0 - c, c)
    s = where(quarter < -0.5, 0.0 - s, s)
    s = where(quarter > 1.5, 0.0 - s, s)
    return c, s


def cosines_and_sines(angles: Pointer, cosines: Pointer, sines: Pointer, count: int) -> None:
    """Cosines and sines of `count` angles.

    For one configuration eight angles are done at a time: there must be room for a multiple of 8.
    """
    raise NotImplementedError


@overload(cosines_and_sines, strict=False, inline="always")
def _cosines_and_sines(angles: Any, cosines: Any, sines: Any, count: Any) -> Any:
    def side_by_side(angles: Pointer, cosines: Pointer, sines: Pointer, count: int) -> None:
        for i in range(count):
            cosines[i], sines[i] = cosine_and_sine(angles[i])

    def alone(angles: Pointer, cosines: Pointer, sines: Pointer, count: int) -> None:
        given, c, s = by_eights(angles), by_eights(cosines), by_eights(sines)
        for i in range((count + 7) // 8):
            c[i], s[i] = cosine_and_sine(given[i])

    return side_by_side if angles.dtype == LANES else alone
