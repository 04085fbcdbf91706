"""Rows of tasks that climb a measure of dexterity: the compiled form of `tasks.measure_climbing` and its measures."""

from __future__ import annotations

import math

from robust_ik.kernels.chain.chain_kinematics import SIX
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.level_freedom import MATRIX, RANK_TOLERANCE, VECTOR, decompose
from robust_ik.kernels.control.rows.frame_motion import END, frame_place, map_of
from robust_ik.kernels.control.rows.jacobian_gradients import add_gradient

FADE = 0.1
"""As `measure_climbing.FADE`."""
CLUSTER = 1e-3
"""As `singular_value.CLUSTER`."""
DOUBTFUL = 1e-9
"""A gradient shorter than this, relative to the twists of the joints, is left to NumPy, which knows if it is flat."""


@called
def climbing_rows(
    program: Pointer, desk: Pointer, task: Pointer, J: Pointer, x: Pointer, error: Pointer, width: Sizes
) -> int:
    """Fills in the row of a task that climbs; UNCERTAIN where the way up is not clear."""
    n, place = int(program[slots.JOINTS]), frame_place(program, desk, int(task[slots.PLACE]))
    m, twists = int(task[slots.COUNT_OF_ROWS]), further(place, END)
    A, U, s, Vt = stack(0.0, ONE, MATRIX), stack(0.0, ONE, MATRIX), stack(0.0, ONE, VECTOR), stack(0.0, ONE, MATRIX)
    gradient, wrench, longest, k = stack(0.0, ONE, VECTOR), stack(0.0, ONE, SIX), 1.0, min(m, n)
    for r in range(m):
        row = int(task[slots.CHOSEN_ROWS + r])
        for c in range(n):
            A[r * n + c] = twists[row * n + c] * (task[slots.SCALE] if row > 2 else 1.0)
            longest = max(longest, abs(A[r * n + c]))
    decompose(A, U, s, Vt, m, n, k, width)
    for c in range(n):
        gradient[c] = 0.0
    index = int(task[slots.INDEX])
    if s[index if task[slots.MEASURE] == slots.OF_SIGMA else k - 1] <= RANK_TOLERANCE * s[0]:
        return slots.UNCERTAIN
    value, shares = 1.0, 0.0
    for i in range(k):
        value *= s[i]
    if task[slots.MEASURE] == slots.OF_SIGMA:
        value = s[index]
    for i in range(k):
        if task[slots.MEASURE] == slots.OF_SIGMA:
            share = max(0.0, 1 - abs(s[i] - value) / (CLUSTER * s[0])) if s[i] > RANK_TOLERANCE * s[0] else 0.0
        else:
            share = value / s[i]
        if share > 0.0:
            for r in range(6):
                wrench[r] = 0.0
            for r in range(m):
                row = int(task[slots.CHOSEN_ROWS + r])
                wrench[row] = U[r * k + i] * (task[slots.SCALE] if row > 2 else 1.0)
            add_gradient(program, desk, int(task[slots.PLACE]), wrench, further(Vt, i * n), share, gradient)
        shares += share
    slope, largest = 0.0, 0.0
    for c in range(n):
        if task[slots.MEASURE] == slots.OF_SIGMA:
            gradient[c] /= shares
        slope += gradient[c] * gradient[c]
        largest = max(largest, abs(gradient[c]))
    if largest <= DOUBTFUL * longest * max(1.0, task[slots.SCALE]) * n * n:
        return slots.UNCERTAIN
    slope = math.sqrt(slope)
    missing = task[slots.THRESHOLD] - value
    off, factor = 0.0, 0.0
    if missing > 0.0:
        off = min(missing / slope, slope / value, task[slots.TOP_SPEED] / task[slots.GAIN_OF])
        factor = task[slots.WEIGHT]
        if math.isfinite(missing):
            factor *= min(1.0, missing / (FADE * task[slots.THRESHOLD]))
    for c in range(n):
        J[c] = gradient[c] / slope * factor * map_of(program, c)[slots.UNIT]
    x[0], error[0] = task[slots.GAIN_OF] * off * factor, off * factor
    return slots.DONE
