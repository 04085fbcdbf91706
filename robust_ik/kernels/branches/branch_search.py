"""All solutions of a pose: roots of the eliminant, the other joints behind each root, Newton's method, limits."""

from __future__ import annotations

import math

from robust_ik.checks import Array
from robust_ik.kernels.branches import branches_layout as lay
from robust_ik.kernels.branches.branches_layout import GROUP, JOINTS, MOTOR
from robust_ik.kernels.branches.circle_roots import MOST_DEGREE, circle_roots
from robust_ik.kernels.branches.group_closing import SINGULAR, moved_pose
from robust_ik.kernels.branches.leaving import is_on_curve
from robust_ik.kernels.branches.loop_equations import (
    SQUARE,
    eliminant,
    equations,
    others,
    products,
    seed_of,
    span_of_pair,
    span_of_slides,
    without,
)
from robust_ik.kernels.branches.loop_state import SIX
from robust_ik.kernels.branches.motors import carried, conjugate, motor_between
from robust_ik.kernels.branches.three_variables import MOST_ROOTS, NEAR_CIRCLE, solve_slides, solve_three
from robust_ik.kernels.branches.within_limits import within
from robust_ik.kernels.compiler.compiling import called, filled, given, inlined, kernel
from robust_ik.kernels.compiler.stack_memory import ONE, W8, Pointer, further, pointer, sizes, stack

MOTORS = sizes(128)
TOGETHER = 2e-3
"""Roots of one solution lie within this."""
FARTHEST = 1e6
"""Joint values that turns are chosen next to are at most this, rad and units of length: others would lose digits."""
ASIDE, FARTHER, WAYS = 1e-3, 10.0, 3
"""How far the first poses beside a degenerate one are, half angles in rad and units of length; how much farther the
next ones; how many there are.

Chosen: eliminants that vanish with the fourth power of the distance are seen over rounding at 1e-2.
"""


@called
def attempt(
    plan: Pointer, axes: Pointer, searched: Pointer, g: Pointer, found: Pointer, count: int, numbers: Pointer
) -> int:  # fmt: skip
    """Adds the solutions of `searched`, settled on g; returns how many there are; fills in the verdict."""
    numbers[lay.CONTINUA] = 0.0
    order, seed, N = stack(0.0, ONE, SIX), stack(0.0, ONE, W8), stack(0.0, ONE, SQUARE)
    motors, M, u = stack(0.0, ONE, MOTORS), stack(0.0, ONE, SQUARE), stack(0.0, ONE, W8)
    left, outside = others(plan, order)
    seed_of(plan, searched, seed)
    products(axes, seed, order, left, outside, motors)
    first = int(plan[lay.FIRST])
    if plan[lay.TRIPLE] == 0.0 and first < JOINTS - 1 and plan[lay.TURNED + first] > 0.0:
        span_of_slides(further(axes, MOTOR * first), further(axes, MOTOR * (first + 1)), N, further(N, GROUP * MOTOR))
    elif plan[lay.TRIPLE] > 0.0 or first < JOINTS - 1:
        for i in range(2 * GROUP * MOTOR):
            N[i] = plan[lay.SPANS + i]
    else:
        conjugate(searched, seed)
        span_of_pair(further(axes, MOTOR * first), seed, axes, N, further(N, GROUP * MOTOR))
    equations(N, motors, 1 << outside, M)
    if plan[lay.TRIPLE] > 0.0:
        doubtful, place = 0, int(plan[lay.PIVOT])
        if plan[lay.SLIDES + int(order[0])] * plan[lay.SLIDES + int(order[1])] * plan[lay.SLIDES + int(order[2])] > 0.0:
            count, one = solve_slides(plan, axes, searched, g, N, order, M, u, motors, found, count, numbers)
            numbers[lay.VERDICT] = lay.EVERY if one else lay.DEGENERATE
            return count
        for turn in range(3):
            count, doubtful, largest = solve_three(
                plan, axes, searched, g, N, order, M, u, motors, found, count, numbers, (place + turn) % 3, -1
            )
            if largest > 0.0:
                numbers[lay.WIDTH], numbers[lay.VERDICT] = largest, lay.EVERY if doubtful == 0 else lay.DOUBTFUL
                if doubtful == 0 and numbers[lay.CONTINUA] > 0.0:
                    numbers[lay.VERDICT] = lay.NEARBY
                return count
        numbers[lay.WIDTH], numbers[lay.VERDICT] = 0.0, lay.DEGENERATE
        return count
    return by_eliminant(plan, axes, searched, g, N, order, M, u, motors, found, count, numbers)


@called
def by_eliminant(
    plan: Pointer, axes: Pointer, searched: Pointer, g: Pointer, N: Pointer, order: Pointer, M: Pointer, u: Pointer,
    motors: Pointer, found: Pointer, count: int, numbers: Pointer,
) -> int:  # fmt: skip
    """`attempt` where the group is a pair: M is (4, 16)."""
    values, C = stack(0.0, ONE, MOST_ROOTS), stack(0.0, ONE, SQUARE)
    x, y, error = stack(0.0, ONE, MOST_ROOTS), stack(0.0, ONE, MOST_ROOTS), stack(0.0, ONE, MOST_ROOTS)
    place, pivot = int(plan[lay.PIVOT]), int(order[int(plan[lay.PIVOT])])
    noise = eliminant(M, place, values)
    many, largest = circle_roots(values, MOST_DEGREE, noise, x, y, error)
    numbers[lay.WIDTH] = largest
    if not largest > 0.0:
        numbers[lay.VERDICT] = lay.DEGENERATE
        return count
    doubtful = 0
    for n in range(many):
        off = abs(math.sqrt(x[n] * x[n] + y[n] * y[n]) - 1.0)
        if off > max(NEAR_CIRCLE, error[n]):
            continue
        angle = math.atan2(y[n], x[n])
        u[2 * place], u[2 * place + 1] = math.cos(0.5 * angle), math.sin(0.5 * angle)
        without(M, place, 4, u[2 * place], u[2 * place + 1], C)
        for turn in range(3):
            count, _, width = solve_three(
                plan, axes, searched, g, N, order, C, u, motors, found, count, numbers, turn, place
            )
            if width > 0.0:
                break
    for n in range(many):
        if abs(math.sqrt(x[n] * x[n] + y[n] * y[n]) - 1.0) > error[n]:
            continue
        together, near = 0, 0
        for k in range(many):
            if abs(math.sqrt(x[k] * x[k] + y[k] * y[k]) - 1.0) <= error[k]:
                together += (x[k] - x[n]) ** 2 + (y[k] - y[n]) ** 2 < TOGETHER**2
        for k in range(count):
            row = further(found, lay.ROW * k)
            if (math.cos(row[pivot]) - x[n]) ** 2 + (math.sin(row[pivot]) - y[n]) ** 2 < TOGETHER**2:
                near += 2 if row[lay.SIGMA] < SINGULAR else 1  # a fold is a double root
        doubtful += near < together
    for k in range(count):
        row = further(found, lay.ROW * k)
        if row[lay.SIGMA] < SINGULAR and is_on_curve(axes, further(plan, lay.SLIDES), g, row):
            numbers[lay.CONTINUA] += 1.0
    numbers[lay.VERDICT] = lay.EVERY if doubtful == 0 else lay.DOUBTFUL
    if doubtful == 0 and numbers[lay.CONTINUA] > 0.0:
        numbers[lay.VERDICT] = lay.NEARBY
    return count


@called
def turned_axes(plan: Pointer, g: Pointer, to: Pointer) -> None:
    """Fills in the axes, (6, 8); those given in world axes pass the tool's point and are turned back by g."""
    back, ray, seen = stack(0.0, ONE, W8), stack(0.0, ONE, W8), stack(0.0, ONE, W8)
    for i in range(JOINTS * MOTOR):
        to[i] = plan[lay.AXES + i]
    conjugate(g, back)
    p = further(plan, lay.POINT)
    for k in range(JOINTS):
        if plan[lay.TURNED + k] > 0.0:
            axis, slides = further(to, MOTOR * k), plan[lay.SLIDES + k] > 0.0
            for i in range(MOTOR):
                ray[i] = 0.0
            for i in range(3):
                ray[1 + i] = axis[5 + i] if slides else axis[1 + i]
            carried(back, ray, seen)
            for i in range(3):
                axis[1 + i] = 0.0 if slides else seen[1 + i]
                axis[5 + i] = seen[1 + i] if slides else 0.0
            if not slides:
                axis[5] = p[1] * seen[3] - p[2] * seen[2]
                axis[6] = p[2] * seen[1] - p[0] * seen[3]
                axis[7] = p[0] * seen[2] - p[1] * seen[1]


@called
def search(plans: Pointer, many: int, g: Pointer, found: Pointer, numbers: Pointer) -> int:
    """Fills in solutions and what is known of them; returns how many there are.

    Plans are tried in turn until one accounts for every root. If none does, two poses to either side are solved, and
    their solutions settle on g: one of them has the solutions that fall together at g.
    """
    axes, near, count = stack(0.0, SIX, W8), stack(0.0, ONE, W8), 0
    numbers[lay.WORK], numbers[lay.BESIDE] = 0.0, 0.0
    turned_axes(plans, g, axes)
    for k in range(many):
        count = attempt(further(plans, lay.SIZE * k), axes, g, g, found, count, numbers)
        if numbers[lay.VERDICT] == lay.EVERY or numbers[lay.VERDICT] == lay.NEARBY:
            return count
    verdict, by = numbers[lay.VERDICT], ASIDE
    for _ in range(WAYS):
        for k in range(many):
            every = True
            for turn in range(2):
                numbers[lay.BESIDE] = by if turn == 0 else -by
                moved_pose(g, numbers[lay.BESIDE], near)
                count = attempt(further(plans, lay.SIZE * k), axes, near, g, found, count, numbers)
                every = every and (numbers[lay.VERDICT] == lay.EVERY or numbers[lay.VERDICT] == lay.NEARBY)
            if every:
                numbers[lay.VERDICT] = lay.NEARBY
                return count
        by *= FARTHER
    numbers[lay.VERDICT] = verdict
    return count


@inlined
def read_out(plan: Pointer, arm: Pointer, near: Pointer, found: Pointer, count: int, values: Pointer) -> None:
    """Fills in values of all joints of the robot, (count, n); those that are not in the loop stay near."""
    n = int(arm[lay.COUNT_OF_VALUES])
    for each in range(count):
        row, to = further(found, lay.ROW * each), further(values, n * each)
        for j in range(n):
            to[j] = near[j]
        for k in range(int(plan[lay.OWN])):
            unit = arm[lay.SCALE] if plan[lay.SLIDES + k] > 0.0 else 1.0
            to[int(arm[lay.COLUMNS + k])] = unit * row[k]


@kernel(given(2), given(1), given(3), given(2), filled(3), filled(3), filled(2))
def branches(
    plans: Array, arm: Array, targets: Array, near: Array, values: Array, found: Array, numbers: Array
) -> bool:  # fmt: skip
    """Solutions of poses (N, 4, 4) after plans (k, SIZE), tried in turn. Shapes are unchecked.

    Args:
        plans: Plans of one arm, the best one first.
        arm: See `branches_layout`.
        targets: The poses.
        near: Joint values that turns are chosen next to, and that solutions are sorted by, (N, n) or (1, n).
        values: Filled, (N, SOLUTIONS, n): joint values, rad and m.
        found: Filled, (N, SOLUTIONS, ROW): the loop's, in its units.
        numbers: Filled, (N, NUMBERS).

    Returns:
        Whether all are rigid poses that are not too far away; of others no solutions are given, with doubt.
    """
    all_plans, packed, n = pointer(plans), pointer(arm), near.shape[1]
    g, close, rigid = stack(0.0, ONE, W8), stack(0.0, ONE, SIX), True
    for i in range(targets.shape[0]):
        start = further(pointer(near), 0 if near.shape[0] == 1 else n * i)
        for k in range(JOINTS):
            close[k] = 0.0
            if k < int(all_plans[lay.OWN]):
                unit = packed[lay.SCALE] if all_plans[lay.SLIDES + k] > 0.0 else 1.0
                close[k] = min(max(start[int(packed[lay.COLUMNS + k])] / unit, -FARTHEST), FARTHEST)
        row, to = further(pointer(numbers), lay.NUMBERS * i), further(pointer(found), lay.SOLUTIONS * lay.ROW * i)
        T = further(pointer(targets), 16 * i)
        rotation, point = further(packed, lay.HOME_ROTATION), further(packed, lay.HOME_POINT)
        if not motor_between(T, rotation, point, packed[lay.SCALE], g):
            row[lay.COUNT], row[lay.ALLOWED], row[lay.VERDICT] = 0.0, 0.0, lay.DOUBTFUL
            rigid = False
            continue
        count = search(all_plans, plans.shape[0], g, to, row)
        within(all_plans, close, to, count, row)
        read_out(all_plans, packed, start, to, int(row[lay.COUNT]), further(pointer(values), lay.SOLUTIONS * n * i))
    return rigid
