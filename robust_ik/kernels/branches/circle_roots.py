"""Roots of a real trigonometric polynomial of degree h from its values at 2h + 1 angles: z = exp(i θ) as complex roots.

Sampling on the circle is as well conditioned as a sum can be. Roots are found all at once.
Source: Aberth 1973; Ehrlich 1967. Start and order do not depend on the polynomial's size.
"""

from __future__ import annotations

import math

import numpy as np

from robust_ik.checks import Array
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, sizes, stack

MOST_DEGREE = 8
"""Largest degree h: a general arm of six revolute joints has 16 solutions."""
TERMS, ANGLES = sizes(2 * MOST_DEGREE + 1), 2 * MOST_DEGREE + 1
ROUNDS = 80
"""Most rounds. Chosen: simple roots take up to 15, triple ones 40."""
SETTLED = 4e-16
"""Relative change of a root after which it stays."""
MOST_TOGETHER = 4
"""Most roots that fall together for which a bound is given."""
VISIBLE = 30.0
"""How many times its rounding a polynomial must be to have roots."""
FLOOR = 1e-9
"""Least bound of what rounding does to a root."""
NOTHING = 1e-13
"""Coefficients below this part of the largest one are rounding: outer ones are dropped, and the degree falls."""


def _unit_circle(h: int) -> Array:
    """exp(2πi j/(2h + 1)) for j = 0 to 2h, as cosines and sines."""
    angles = 2.0 * np.pi * np.arange(2 * h + 1) / (2 * h + 1)
    return np.ascontiguousarray(np.concatenate([np.cos(angles), np.sin(angles)]))


CIRCLE_2, CIRCLE_8 = _unit_circle(2), _unit_circle(8)


@called
def coefficients(values: Pointer, h: int, re: Pointer, im: Pointer) -> float:
    """Fills in c₋ₕ … cₕ of Σ cₖ zᵏ from values at 2h + 1 angles, h = 2 or 8; returns the largest |cₖ|."""
    count, largest = 2 * h + 1, 0.0
    for k in range(h + 1):
        a, b = 0.0, 0.0
        for j in range(count):
            place = (j * k) % count
            if h == MOST_DEGREE:
                a += values[j] * CIRCLE_8[place]
                b -= values[j] * CIRCLE_8[count + place]
            else:
                a += values[j] * CIRCLE_2[place]
                b -= values[j] * CIRCLE_2[count + place]
        a, b = a / count, b / count
        re[h + k], im[h + k], re[h - k], im[h - k] = a, b, a, -b
        largest = max(largest, math.sqrt(a * a + b * b))
    return largest


@called
def circle_roots(
    values: Pointer, h: int, noise: float, x: Pointer, y: Pointer, error: Pointer
) -> tuple[int, float]:  # fmt: skip
    """Fills in the roots z = x + i y and a bound of what rounding does to each.

    Args:
        values: Those at 2πj/(2h + 1), j = 0 to 2h.
        h: The degree, 2 or 8.
        noise: How far rounding may have moved each value.
        x: Filled, up to 2h.
        y: The same.
        error: The same: rounding of coefficients over |p′|, infinite where p′ is 0.

    Returns:
        How many roots there are, and the largest |coefficient|; no roots and 0 if all may be rounding.
    """
    re, im = stack(0.0, ONE, TERMS), stack(0.0, ONE, TERMS)
    largest = coefficients(values, h, re, im)
    if not largest > VISIBLE * noise:
        return 0, 0.0
    first = 0
    while first < h and max(abs(re[first]), abs(im[first])) <= max(NOTHING * largest, noise):
        first += 1
    degree = 2 * (h - first)
    total = 0.0
    for k in range(degree + 1):
        total += math.sqrt(re[first + k] ** 2 + im[first + k] ** 2)
    for k in range(degree):
        angle = 2.0 * math.pi * (k + 0.3) / degree + 0.1
        radius = 1.15 if k % 2 else 0.85
        x[k], y[k] = radius * math.cos(angle), radius * math.sin(angle)
        error[k] = 0.0
    for _ in range(ROUNDS):
        moved = 0.0
        for k in range(degree):
            if error[k] < 0.0:
                continue
            p, q, dp, dq = re[first + degree], im[first + degree], 0.0, 0.0
            for n in range(degree - 1, -1, -1):
                dp, dq = dp * x[k] - dq * y[k] + p, dp * y[k] + dq * x[k] + q
                p, q = p * x[k] - q * y[k] + re[first + n], p * y[k] + q * x[k] + im[first + n]
            # The Newton step w = p/p′, and w/(1 − w Σ 1/(zₖ − zₙ)).
            a, b = 0.0, 0.0
            for n in range(degree):
                if n != k:
                    dx, dy = x[k] - x[n], y[k] - y[n]
                    square = dx * dx + dy * dy
                    if square > 0.0:
                        a, b = a + dx / square, b - dy / square
            # p′ − p Σ
            a, b = dp - (p * a - q * b), dq - (p * b + q * a)
            square = a * a + b * b
            if not square > 0.0:
                continue
            wx, wy = (p * a + q * b) / square, (q * a - p * b) / square
            size = math.sqrt(x[k] * x[k] + y[k] * y[k])
            step = math.sqrt(wx * wx + wy * wy)
            x[k], y[k] = x[k] - wx, y[k] - wy
            if step <= SETTLED * size:
                error[k] = -1.0
            moved = max(moved, step / max(size, 1e-300))
        if moved <= SETTLED:
            break
    rounding = max(NOTHING * total, noise)
    for k in range(degree):
        error[k] = shift_of(re, im, first, degree, x[k], y[k], rounding)
    return degree, largest


@called
def shift_of(re: Pointer, im: Pointer, first: int, degree: int, x: float, y: float, rounding: float) -> float:
    """How far a root moves if p changes by `rounding`: the least of (rounding/|bₘ|)^(1/m), p = Σ bₘ (z − x − iy)ᵐ."""
    a, b, least = stack(0.0, ONE, TERMS), stack(0.0, ONE, TERMS), math.inf
    for n in range(degree + 1):
        a[n], b[n] = re[first + n], im[first + n]
    for m in range(min(MOST_TOGETHER, degree) + 1):
        for n in range(degree - 1, m - 1, -1):
            a[n], b[n] = a[n] + a[n + 1] * x - b[n + 1] * y, b[n] + a[n + 1] * y + b[n + 1] * x
        size = math.sqrt(a[m] * a[m] + b[m] * b[m])
        if m > 0 and size > 0.0:
            least = min(least, (rounding / size) ** (1.0 / m))
    return max(least, FLOOR)
