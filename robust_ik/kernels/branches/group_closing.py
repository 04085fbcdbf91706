"""The joints of the group behind given others; candidates settle on a solution, and are added if they are new."""

from __future__ import annotations

import math

from robust_ik.kernels.branches import branches_layout as lay
from robust_ik.kernels.branches.branches_layout import GROUP, JOINTS, MOTOR
from robust_ik.kernels.branches.loop_equations import motor_at
from robust_ik.kernels.branches.loop_state import SIX, change, loop_state
from robust_ik.kernels.branches.motors import multiply
from robust_ik.kernels.branches.pencils import FOUR, factors, quadratic_form_roots, twisted
from robust_ik.kernels.branches.settling import newton_step, settle
from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import ONE, W8, Pointer, further, stack

SAME = 1e-6
"""Solutions that differ by less are one, rad or units of length."""
SEEN, AS_GOOD = 2e-13, 4.0
"""An error halfway between two solutions up to which they are one, by itself and over their own: rounding of poses."""
FAR_BELOW, LEAST_PIVOT = 3.0, 1e-9
"""Pivots up to this many times the weakest one of two solutions, and this one, count as weak between them."""
CLOSE_BY, WEAK_PIVOT = 1e-2, 1e-2
"""How near two solutions are, and how small the least pivot is, where they may be the ends of a double root."""
SINGULAR = 1e-5
"""Least pivot up to which a solution may stand for several roots."""
HALVES = 8
"""How many poses between one beside the wanted one and that one a solution is led through, each half as far."""
VANISHING = 1e-9
"""A slide's c, of (c, s) of length 1, up to which its length is infinite."""
DOUBLE = 1e-6
"""A discriminant, of coefficients of size 1, up to which below zero a root is tried as a double one."""


@inlined
def joint_value(u: Pointer, slides: bool) -> float:
    """The joint value of u = (c, s), an infinite one where a slide's c is 0."""
    if slides:
        return 2.0 * u[1] / u[0] if abs(u[0]) > VANISHING else math.inf
    return 2.0 * math.atan2(u[1], u[0])


@called
def distance(a: Pointer, b: Pointer, slides: Pointer) -> float:
    """The largest difference of two solutions, turns modulo 2π."""
    largest = 0.0
    for k in range(JOINTS):
        largest = max(largest, abs(change(a[k] - b[k], slides[k])))
    return largest


@called
def moved_pose(g: Pointer, by: float, to: Pointer) -> None:
    """Fills in g after a small displacement in a general direction."""
    step = stack(0.0, ONE, W8)
    step[0], step[4] = 1.0, 0.0
    step[1], step[2], step[3] = 0.61 * by, -0.43 * by, 0.66 * by
    step[5], step[6], step[7] = 0.35 * by, 0.72 * by, -0.52 * by
    step[4] = -(step[1] * step[5] + step[2] * step[6] + step[3] * step[7])
    size = math.sqrt(1.0 + step[1] ** 2 + step[2] ** 2 + step[3] ** 2)
    for i in range(MOTOR):
        step[i] /= size
    multiply(step, g, to)


@called
def add(
    plan: Pointer, axes: Pointer, searched: Pointer, g: Pointer, q: Pointer, found: Pointer, count: int,
    numbers: Pointer,
) -> int:  # fmt: skip
    """Settles a candidate on the pose that was searched, then on g; adds it if it is new; returns how many there are.

    Returns:
        The number of solutions; minus one minus that number if the candidate is no solution.
    """
    slides, middle = further(plan, lay.SLIDES), stack(0.0, ONE, SIX)
    J, twist, step = stack(0.0, SIX, SIX), stack(0.0, ONE, SIX), stack(0.0, ONE, SIX)
    near = stack(0.0, ONE, W8)
    for k in range(JOINTS):
        if not abs(q[k]) < 1e9:
            return -1 - count
    is_one, weakest, miss, steps = settle(axes, slides, searched, q)
    numbers[lay.WORK] += steps
    if is_one and numbers[lay.BESIDE] != 0.0:
        by = numbers[lay.BESIDE]
        for _ in range(HALVES):
            by *= 0.5
            moved_pose(g, by, near)
            settle(axes, slides, near, q)
        is_one, weakest, miss, steps = settle(axes, slides, g, q)
        numbers[lay.WORK] += steps
    if not is_one:
        return -1 - count
    for n in range(count):
        other, far = further(found, lay.ROW * n), 0.0
        far = distance(q, other, slides)
        if far < SAME:
            return count
        if far < CLOSE_BY and weakest < WEAK_PIVOT:
            # Two ends of a double root: halfway, put right in the directions that are not weak, is a solution, too, as
            # far as doubles can tell.
            for k in range(JOINTS):
                middle[k] = other[k] + 0.5 * change(q[k] - other[k], slides[k])
            weak = FAR_BELOW * max(weakest, other[lay.SIGMA], LEAST_PIVOT)
            for _ in range(2):
                loop_state(axes, slides, JOINTS, middle, g, g, 6, J, twist)
                newton_step(J, twist, weak, step)
                for k in range(JOINTS):
                    middle[k] += step[k]
            if loop_state(axes, slides, JOINTS, middle, g, g, 6, J, twist) <= max(
                SEEN, AS_GOOD * max(miss, other[lay.MISS])
            ):
                return count
    if count < lay.SOLUTIONS:
        row = further(found, lay.ROW * count)
        for k in range(JOINTS):
            row[k] = q[k]
        row[lay.SIGMA], row[lay.MISS], row[lay.INSIDE] = weakest, miss, 1.0
        return count + 1
    return count


@called
def close_group(
    plan: Pointer, axes: Pointer, searched: Pointer, g: Pointer, N: Pointer, order: Pointer, u: Pointer,
    motors: Pointer, found: Pointer, count: int, numbers: Pointer, flat: float,
) -> tuple[int, bool]:  # fmt: skip
    """Adds the solutions with these variables outside the group; how many there are, and if any was added or known.

    Args:
        plan: See `branches_layout`.
        axes: (6, 8).
        searched: The pose whose solutions are looked for.
        g: The pose they settle on.
        N: N and S⁺, (2, 4, 8).
        order: The joints outside the group.
        u: Their (c, s).
        motors: Products of (1, −A) outside the group.
        found: Solutions.
        count: How many.
        numbers: What is known of them.
        flat: Coefficients up to which a form of unit vectors counts as zero.
    """
    slides, q, x = further(plan, lay.SLIDES), stack(0.0, ONE, SIX), stack(0.0, ONE, W8)
    triple, first = plan[lay.TRIPLE] > 0.0, int(plan[lay.FIRST])
    outside = 3 if triple else 4
    motor, turned, y = stack(0.0, ONE, W8), stack(0.0, ONE, W8), stack(0.0, ONE, W8)
    v, w, roots, base = stack(0.0, ONE, FOUR), stack(0.0, ONE, FOUR), stack(0.0, ONE, FOUR), stack(0.0, ONE, SIX)
    any_one = False
    motor_at(motors, u, outside, motor)
    for i in range(outside):
        k = int(order[i])
        base[k] = joint_value(further(u, 2 * i), slides[k] > 0.0)
    parts = further(N, GROUP * MOTOR)
    if not triple:
        size = 0.0
        for r in range(GROUP):
            x[r] = 0.0
            for i in range(MOTOR):
                x[r] += parts[MOTOR * r + i] * motor[i]
            size += x[r] * x[r]
        a, b = first, (first + 1) % JOINTS
        if slides[a] > 0.0 and slides[b] > 0.0:  # their product is a sum: (1, d_b, d_a, 0)
            x[3] = x[1] * x[2] / x[0] if x[0] != 0.0 else 0.0
        factors(x, v, w)
        for k in range(JOINTS):
            q[k] = base[k]
        q[a], q[b] = joint_value(v, slides[a] > 0.0), joint_value(w, slides[b] > 0.0)
        after = add(plan, axes, searched, g, q, found, count, numbers)
        return (after, True) if after >= 0 else (-1 - after, False)
    axis = further(axes, MOTOR * first)
    multiply(axis, motor, turned)
    size = 0.0
    for r in range(GROUP):
        y[r], y[GROUP + r] = 0.0, 0.0
        for i in range(MOTOR):
            y[r] += parts[MOTOR * r + i] * motor[i]
            y[GROUP + r] -= parts[MOTOR * r + i] * turned[i]
        size += y[r] * y[r] + y[GROUP + r] * y[GROUP + r]
    size = math.sqrt(size)
    for r in range(2 * GROUP):
        y[r] /= size
    mixed = y[0] * y[7] + y[4] * y[3] - y[1] * y[6] - y[5] * y[2]
    many = quadratic_form_roots(twisted(y), mixed, twisted(further(y, GROUP)), roots, DOUBLE, flat)
    if many < 0:
        roots[0], roots[1], many = 1.0, 0.0, 1  # any value is a solution: 0
    for n in range(many):
        for r in range(GROUP):
            x[r] = roots[2 * n] * y[r] + roots[2 * n + 1] * y[GROUP + r]
        factors(x, v, w)
        for k in range(JOINTS):
            q[k] = base[k]
        q[first] = joint_value(further(roots, 2 * n), slides[first] > 0.0)
        q[first + 1] = joint_value(v, slides[first + 1] > 0.0)
        q[first + 2] = joint_value(w, slides[first + 2] > 0.0)
        after = add(plan, axes, searched, g, q, found, count, numbers)
        any_one = any_one or after >= 0
        count = after if after >= 0 else -1 - after
    return count, any_one or many == 0
