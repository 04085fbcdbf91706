"""Solves four equations in three variables: one by the roots of a determinant, two by its null space."""

from __future__ import annotations

import math

from robust_ik.kernels.branches import branches_layout as lay
from robust_ik.kernels.branches.circle_roots import CIRCLE_2, MOST_DEGREE, circle_roots
from robust_ik.kernels.branches.group_closing import DOUBLE, close_group
from robust_ik.kernels.branches.loop_equations import without
from robust_ik.kernels.branches.pencils import (
    FIVE,
    FOUR,
    SIXTEEN,
    determinant,
    factors,
    null_space,
    quadratic_form_roots,
    twisted,
)
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, further, sizes, stack

MOST_ROOTS = sizes(2 * MOST_DEGREE + 1)
WEAK = 1e-12
"""A determinant whose coefficients are below this part of its possible size vanishes."""
NEAR_CIRCLE = 3e-3
"""Roots that are off the circle by up to this are tried, even if no rounding puts them on it."""
INFINITE = 2e-3
"""A slide's c, of (c, s) of length 1, up to which its length, 2 s/c, counts as infinite: a thousand arms."""
FLAT, STEEP = 1e-5, 30.0
"""Pivots of a 4 × 4 matrix up to this part of the largest one count as zero at a root of its determinant, or up to
this many times what rounding may have moved the root.

Chosen: a simple root is known to 1e-12, a double one to 1e-7, a fourfold one to 1e-4.
"""
ALL = 1e-9
"""Coefficients of a form of unit vectors up to which it counts as zero everywhere, at a root that is known exactly."""
SAMPLES = 8
"""How many of a continuum of values of two variables are tried."""
LIKE_A_PRODUCT = 1e-2
"""Largest distance of y from a product that is tried."""


@called
def solve_slides(
    plan: Pointer, axes: Pointer, searched: Pointer, g: Pointer, N: Pointer, order: Pointer, C: Pointer, u: Pointer,
    motors: Pointer, found: Pointer, count: int, numbers: Pointer,
) -> tuple[int, bool]:  # fmt: skip
    """Adds the solutions where all three variables are slides, so that equations are linear; see `solve_three`.

    Returns:
        How many there are, and whether the equations have one solution.
    """
    matrix, basis = stack(0.0, ONE, SIXTEEN), stack(0.0, ONE, SIXTEEN)
    for r in range(4):
        matrix[4 * r] = C[8 * r]
        for place in range(3):
            matrix[4 * r + 1 + place] = C[8 * r + (4 >> place)]
    if null_space(matrix, FLAT, basis) != 1:
        return count, False
    for place in range(3):
        u[2 * place], u[2 * place + 1] = basis[0], basis[1 + place]
    count, _ = close_group(plan, axes, searched, g, N, order, u, motors, found, count, numbers, ALL)
    return count, True


@called
def solve_three(
    plan: Pointer, axes: Pointer, searched: Pointer, g: Pointer, N: Pointer, order: Pointer, C: Pointer, u: Pointer,
    motors: Pointer, found: Pointer, count: int, numbers: Pointer, place: int, outer: int,
) -> tuple[int, int, float]:  # fmt: skip
    """Adds the solutions of four equations in three variables, C (4, 8); the variable at `place` is found first.

    Args:
        plan: See `close_group`, as axes to N.
        axes: The same.
        searched: The same.
        g: The same.
        N: The same.
        order: The same.
        C: The equations.
        u: The variables (c, s) of all joints outside the group; three of them are filled in.
        motors: See `close_group`.
        found: The same.
        count: How many solutions there are.
        numbers: See `close_group`.
        place: 0, 1 or 2.
        outer: Place in u of the variable that is given, −1 if none is.

    Returns:
        How many solutions there are; how many roots are left without one; the largest coefficient of the pencil's
        determinant, 0 if it vanishes.
    """
    matrix, values, basis = stack(0.0, ONE, SIXTEEN), stack(0.0, ONE, FIVE), stack(0.0, ONE, SIXTEEN)
    x, y, error = stack(0.0, ONE, MOST_ROOTS), stack(0.0, ONE, MOST_ROOTS), stack(0.0, ONE, MOST_ROOTS)
    size, noise, left = 0.0, 0.0, 0
    for r in range(4 * 8):
        size += C[r] * C[r]
    for j in range(5):
        c = math.sqrt(max(0.5 * (1.0 + CIRCLE_2[j]), 0.0)) * (1.0 if 2 * j < 5 else -1.0)
        without(C, place, 3, c, math.sqrt(max(0.5 * (1.0 - CIRCLE_2[j]), 0.0)), matrix)
        values[j], bound = determinant(matrix, 4)
        noise = max(noise, bound)
    many, largest = circle_roots(values, 2, noise, x, y, error)
    if not largest > WEAK * size * size:
        return count, 0, 0.0
    first, second, third = place, (1 if place == 0 else 0), (1 if place == 2 else 2)
    # Places among all variables outside the group.
    a = first + (1 if 0 <= outer <= first else 0)
    b = second + (1 if 0 <= outer <= second else 0)
    d = third + (1 if 0 <= outer <= third else 0)
    v, w = stack(0.0, ONE, FOUR), stack(0.0, ONE, FOUR)
    roots, trial = stack(0.0, ONE, FOUR), stack(0.0, ONE, FOUR)
    for n in range(many):
        off = abs(math.sqrt(x[n] * x[n] + y[n] * y[n]) - 1.0)
        if off > max(NEAR_CIRCLE, error[n]):
            continue
        half = 0.5 * math.atan2(y[n], x[n])
        u[2 * a], u[2 * a + 1] = math.cos(half), math.sin(half)
        if plan[lay.SLIDES + int(order[a])] > 0.0 and abs(u[2 * a]) < INFINITE:
            continue
        without(C, place, 3, u[2 * a], u[2 * a + 1], matrix)
        dimension = null_space(matrix, max(FLAT, STEEP * error[n]), basis)
        tried, got, whole = 0, False, False
        if dimension == 2:
            one, two = basis, further(basis, 4)
            cross = one[0] * two[3] + two[0] * one[3] - one[1] * two[2] - two[1] * one[2]
            tried = quadratic_form_roots(twisted(one), cross, twisted(two), roots, DOUBLE, max(ALL, STEEP * error[n]))
            if tried < 0:
                tried, whole = SAMPLES, True
                numbers[lay.CONTINUA] += 1.0
        elif dimension == 1 and abs(twisted(basis)) < LIKE_A_PRODUCT:
            roots[0], roots[1], tried = 1.0, 0.0, 1
        elif dimension > 2:
            left += 1
            continue
        for i in range(tried):
            part, other = roots[2 * (i % 2)], roots[2 * (i % 2) + 1]
            if whole:
                part, other = math.cos(math.pi * i / SAMPLES), math.sin(math.pi * i / SAMPLES)
            for r in range(4):
                trial[r] = part * basis[r]
                if dimension == 2:
                    trial[r] += other * basis[4 + r]
            factors(trial, v, w)
            u[2 * b], u[2 * b + 1], u[2 * d], u[2 * d + 1] = v[0], v[1], w[0], w[1]
            count, one_is = close_group(
                plan, axes, searched, g, N, order, u, motors, found, count, numbers, max(ALL, STEEP * error[n])
            )
            got = got or one_is
        got = got or whole
        if off <= error[n] and not got and (tried > 0 or outer < 0):
            left += 1
    return count, left, largest
