"""Newton's method on the closed loop: a candidate settles on a solution, or it is none.

Source: Newton–Raphson on E_0(q_0) … E_5(q_5) = g.
"""

from __future__ import annotations

import math

from robust_ik.kernels.branches.branches_layout import JOINTS
from robust_ik.kernels.branches.loop_state import SIX, change, loop_state
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, stack

STEPS = 24
"""Most steps. Chosen: simple solutions take 1 to 3; at a singular one each step halves the distance."""
CLOSE = 1e-11
"""Largest entry of the error's twist, rad or units of length, that a solution may have.

Chosen: poses of files whose rotations are written with twelve digits are off by 1e-12 in directions that are lost.
"""
EXACT = 4e-15
"""An error below which no further step is taken."""
LONGEST = 0.5
"""Longest step of a joint, rad or units of length."""
SMALLEST_PIVOT, STEEP = 1e-9, 20.0
"""Pivots below this part of the largest one give no motion, nor do those up to this many times the error: their step
would be longer than 1/20. At a fold the error is the square of the pivot, which is kept.
"""


@called
def newton_step(J: Pointer, twist: Pointer, smallest: float, step: Pointer) -> float:
    """Fills in J⁻¹ twist, (6,), without the motions of weak pivots; returns the least pivot over the largest one.

    J and twist are destroyed. Complete pivots; those up to `smallest` of the largest one are weak.
    """
    columns = stack(0.0, ONE, SIX)
    for j in range(6):
        columns[j], step[j] = float(j), 0.0
    rank, first, weakest = 6, 0.0, 1.0
    for k in range(6):
        row, column, largest = k, k, -1.0
        for i in range(k, 6):
            for j in range(k, 6):
                if abs(J[6 * i + j]) > largest:
                    row, column, largest = i, j, abs(J[6 * i + j])
        if k == 0:
            first = largest
        weakest = largest / first if first > 0.0 else 0.0
        if not weakest > smallest:
            rank = k
            break
        if row != k:
            for j in range(6):
                J[6 * k + j], J[6 * row + j] = J[6 * row + j], J[6 * k + j]
            twist[k], twist[row] = twist[row], twist[k]
        if column != k:
            for i in range(6):
                J[6 * i + k], J[6 * i + column] = J[6 * i + column], J[6 * i + k]
            columns[k], columns[column] = columns[column], columns[k]
        for i in range(k + 1, 6):
            factor = J[6 * i + k] / J[6 * k + k]
            for j in range(k + 1, 6):
                J[6 * i + j] -= factor * J[6 * k + j]
            twist[i] -= factor * twist[k]
    for k in range(rank - 1, -1, -1):
        total = twist[k]
        for j in range(k + 1, rank):
            total -= J[6 * k + j] * twist[j]
        twist[k] = total / J[6 * k + k]
        step[int(columns[k])] = twist[k]
    return weakest


@called
def settle(axes: Pointer, slides: Pointer, g: Pointer, q: Pointer) -> tuple[bool, float, float, int]:
    """Moves q, (6,), onto a solution near it; whether it is one, its least pivot, its error, and the steps taken."""
    J, twist, step, best = stack(0.0, SIX, SIX), stack(0.0, ONE, SIX), stack(0.0, ONE, SIX), stack(0.0, ONE, SIX)
    least, weakest, vain, steps = math.inf, 0.0, 0, 0
    for _ in range(STEPS):
        steps += 1
        error = loop_state(axes, slides, JOINTS, q, g, g, 6, J, twist)
        if error < least:
            vain = 0
            least = error
            for k in range(JOINTS):
                best[k] = q[k]
        else:
            vain += 1
        if not error < math.inf or vain > 2:
            break
        pivot = newton_step(J, twist, max(SMALLEST_PIVOT, STEEP * error), step)
        if error == least:
            weakest = pivot
        if error <= EXACT:
            break
        longest = 0.0
        for k in range(JOINTS):
            longest = max(longest, abs(step[k]))
        factor = min(1.0, LONGEST / longest) if longest > 0.0 else 1.0
        for k in range(JOINTS):
            q[k] += factor * step[k]
    for k in range(JOINTS):
        q[k] = change(best[k], slides[k])
    return least <= CLOSE, weakest, least, steps
