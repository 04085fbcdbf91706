"""Solutions on the boundary of the reachable poses: J is singular there, and steps by J alone zigzag or creep.

Let u be the direction in which joints can hardly move the pose. At such a solution u · pose has an extremum among the
configurations that are right in all other directions. Newton's method for this extremum is regular and takes four or
five steps.
"""

from __future__ import annotations

import math

from robust_ik.kernels.chain import chain_layout as links
from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import ONE, W8, W16, Pointer, sizes, stack
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kernels.pose.damped_step import along, columns, normal_matrix, solve
from robust_ik.kernels.pose.error_hessian import curvature
from robust_ik.kernels.pose.newton_polish import ROOM, SIX, TWELVE, look, newton_step, reached

ROUNDS, SETTLED = 8, 2
"""Most steps, and the number of steps after which each must bring E below FALL times the last one.

Where it converges it takes four or five.
"""
FALL = 0.5
"""Largest fraction of E that a step may leave.

Chosen: Newton's method leaves far less near a solution; more wastes steps.
"""
LONGEST = 0.5
"""Largest entry of a step, rad or m. Chosen: beyond it the second derivatives no longer hold."""
PART = 1e-4
"""Weight of the extremum against the other directions, which it disturbs by about its square."""
FLAT = 0.05
"""Least singular value, m per rad, above which no extremum is looked for. Chosen: above it steps by J alone suffice."""
LEAST = 1e-14
"""Damping, m² per rad²: keeps pivots from zero. Chosen: the square of 1e-7, far below any σ that moves the pose."""
BLOCK = sizes(6)


@inlined
def pressable(problem: Pointer) -> bool:
    """Whether solutions on the boundary are looked for: not if some rotations are wanted and others free."""
    kind = int(problem[lay.TURN])
    return bool(kind == lay.NONE or kind == lay.FULL)


@called
def press(problem: Pointer, options: Pointer, values: Pointer, target: Pointer, edge: bool, error: Pointer) -> int:
    """Moves values to a solution on the boundary and measures the error there; returns the number of steps.

    If that fails, values stay as they were and the error is not within tolerances.

    Args:
        problem: See `pose_layout`; of the rotations, none or all must be wanted.
        options: The same.
        values: Joint values.
        target: Rotation, row by row, and position.
        edge: Whether the values are on the boundary themselves, so that the target lies inwards of them.
        error: Filled, see `measure`.
    """
    k, scale = int(problem[lay.COUNT]), options[lay.SCALE]
    axes, end, twists = stack(0.0, ROOM, SIX), stack(0.0, ONE, TWELVE), stack(0.0, ROOM, SIX)
    J, s, d = stack(0.0, W16, W8), stack(0.0, ONE, W16), stack(0.0, ONE, W16)
    right, free, trial = stack(0.0, ONE, W16), stack(0.0, ONE, W16), stack(0.0, ONE, W16)
    e, u = stack(0.0, ONE, W8), stack(0.0, ONE, W8)
    for j in range(k):
        trial[j] = values[j]
    look(problem, trial, target, axes, end, error)
    rounds, part, E = 0, PART, error[6] + scale * scale * error[7]
    while rounds < ROUNDS and not reached(options, error):
        rounds += 1
        for r in range(3):
            e[r], e[3 + r] = error[r], scale * error[3 + r]
        again(problem, axes, twists)
        columns(problem, twists, end, error, scale, J, 0.0)
        hold(problem, trial, e, J, right, free)
        if rounds == 1:
            for r in range(6):
                u[r] = e[r]
            across(J, k, u)
        across(J, k, u)
        inner, square = 0.0, 0.0
        for r in range(6):
            inner += u[r] * e[r]
        for j in range(k):
            s[j] = along(J, j, u)
            square += s[j] * s[j]
            right[j] -= inner * s[j]
        if square > FLAT * FLAT:
            break
        if rounds == 1 and (inner < 0.0) != edge:
            part = -PART
        if not climb(problem, axes, end, target, scale, part, u, s, right, free, d):
            part = -part
            if not climb(problem, axes, end, target, scale, part, u, s, right, free, d):
                break
        most = LONGEST
        for j in range(k):
            most = max(most, abs(d[j]))
        for j in range(k):
            at = lay.HEAD + j * lay.STRIDE
            trial[j] = min(max(trial[j] + LONGEST / most * d[j], problem[at + lay.LOWER]), problem[at + lay.UPPER])
        look(problem, trial, target, axes, end, error)
        now = error[6] + scale * scale * error[7]
        if rounds >= SETTLED and now > FALL * E:
            break
        E = now
    if reached(options, error):
        for j in range(k):
            values[j] = trial[j]
    return rounds


@inlined
def again(problem: Pointer, axes: Pointer, twists: Pointer) -> None:
    """Copies axes, since `joint_twists` overwrites them."""
    for x in range(6 * int(problem[int(problem[lay.CHAIN]) + links.JOINTS])):
        twists[x] = axes[x]


@called
def hold(problem: Pointer, values: Pointer, e: Pointer, J: Pointer, right: Pointer, free: Pointer) -> None:
    """Fills Jᵀe, marks joints that e pushes against their limits as not free, and sets their columns of J to zero."""
    for j in range(int(problem[lay.COUNT])):
        at, right[j] = lay.HEAD + j * lay.STRIDE, along(J, j, e)
        out = (values[j] <= problem[at + lay.LOWER] and right[j] < 0.0) or (
            values[j] >= problem[at + lay.UPPER] and right[j] > 0.0
        )
        free[j] = 0.0 if out else 1.0
        for r in range(6):
            J[8 * j + r] *= free[j]


@called
def climb(
    problem: Pointer,
    axes: Pointer,
    end: Pointer,
    target: Pointer,
    scale: float,
    part: float,
    u: Pointer,
    s: Pointer,
    right: Pointer,
    free: Pointer,
    d: Pointer,
) -> bool:
    """Fills d with a step towards the extremum of part · u · pose with all else right; False if there is none.

    It solves (Jᵀ(1 − u uᵀ)J − part Σ u ∂²pose/∂q²) d = Jᵀ(1 − u uᵀ)e + part Jᵀu; s is Jᵀu, `right` Jᵀ(1 − u uᵀ)e.
    """
    k = int(problem[lay.COUNT])
    H, g, pushed = stack(0.0, W16, W16), stack(0.0, ONE, W16), stack(0.0, ONE, TWELVE)
    twists = stack(0.0, ROOM, SIX)
    again(problem, axes, twists)
    for r in range(3):
        pushed[r], pushed[3 + r] = part * u[r], part * u[3 + r] / scale
        pushed[9 + r] = pushed[3 + r]
    pushed[6], pushed[7], pushed[8] = 0.0, 0.0, 1.0
    curvature(problem, twists, end, target, pushed, scale, H, g)
    for i in range(k):
        g[i] = right[i] + part * s[i]
        for j in range(k):
            H[16 * i + j] -= s[i] * s[j]
    return bool(newton_step(H, g, free, LEAST, k, d))


@called
def across(J: Pointer, k: int, u: Pointer) -> None:
    """Turns u towards the unit vector that Jᵀ shortens most, by one step of inverse iteration."""
    A, b, y = stack(0.0, BLOCK, W8), stack(0.0, ONE, W8), stack(0.0, ONE, W16)
    length = 0.0
    for r in range(6):
        b[r] = u[r]
    normal_matrix(J, k, A)
    solve(A, LEAST, b, y, 0.0)
    for r in range(6):
        length += y[r] * y[r]
    for r in range(6):
        u[r] = y[r] / math.sqrt(max(length, 1e-300))
