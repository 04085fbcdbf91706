"""Rows of tasks that climb a measure of dexterity: the compiled form of `tasks.measure_climbing` and its measures."""

from __future__ import annotations

import math

from robust_ik.kernels.chain import chain_layout as links
from robust_ik.kernels.chain.chain_kinematics import MOST_JOINTS, SIX
from robust_ik.kernels.chain.hessian_contraction import bend
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.frame_motion import END, frame_place, map_of
from robust_ik.kernels.control.level_freedom import MATRIX, RANK_TOLERANCE, VECTOR
from robust_ik.kernels.matrices.small_svd import decompose_some

FADE = 0.1
"""As `measure_climbing.FADE`."""
CLUSTER = 1e-3
"""As `singular_value.CLUSTER`."""
DOUBTFUL = 1e-9
"""A gradient shorter than this, relative to the twists of the joints, is left to NumPy, which knows if it is flat."""


@called
def add_gradient(
    program: Pointer, task: Pointer, place: Pointer, u: Pointer, stride: int, v: Pointer, share: float,
    gradient: Pointer,
) -> None:  # fmt: skip
    """Adds share · uᵀ (∂J/∂q) v; u has a number every `stride` places, one for each row of the measure."""
    n, chain = (
        int(program[slots.JOINTS]),
        further(program, int(program[int(program[slots.FRAME]) + 2 * int(task[slots.PLACE])])),
    )
    twists, count = further(place, END + 6 * n), int(chain[links.JOINTS])
    motions, bends, wrench = stack(0.0, ONE, MOST_JOINTS), stack(0.0, MOST_JOINTS, SIX), stack(0.0, ONE, SIX)
    for i in range(6):
        wrench[i] = 0.0
    for r in range(int(task[slots.COUNT_OF_ROWS])):
        row = int(task[slots.CHOSEN_ROWS + r])
        wrench[row] = u[r * stride] * (task[slots.SCALE] if row > 2 else 1.0)
    for i in range(count):
        at = links.HEAD + i * links.STRIDE
        motions[i] = chain[at + links.FACTOR] * v[int(chain[at + links.COLUMN])]
    bend(twists, motions, count, bends, 0.0)
    for k in range(count):
        at, total = links.HEAD + k * links.STRIDE, 0.0
        for r in range(6):
            total += wrench[r] * bends[6 * k + r]
        gradient[int(chain[at + links.COLUMN])] += share * chain[at + links.FACTOR] * total


@called
def climbing_rows(
    program: Pointer, desk: Pointer, task: Pointer, J: Pointer, x: Pointer, error: Pointer, width: Sizes
) -> int:
    """Fills in the row of a task that climbs; UNCERTAIN where the way up is not clear."""
    n, place = int(program[slots.JOINTS]), frame_place(program, desk, int(task[slots.PLACE]))
    m, twists = int(task[slots.COUNT_OF_ROWS]), further(place, END)
    A, U, s, Vt = stack(0.0, ONE, MATRIX), stack(0.0, ONE, MATRIX), stack(0.0, ONE, VECTOR), stack(0.0, ONE, MATRIX)
    gradient, longest, k = stack(0.0, ONE, VECTOR), 1.0, min(m, n)
    for r in range(m):
        row = int(task[slots.CHOSEN_ROWS + r])
        for c in range(n):
            A[r * n + c] = twists[row * n + c] * (task[slots.SCALE] if row > 2 else 1.0)
            longest = max(longest, abs(A[r * n + c]))
    decompose_some(A, U, s, Vt, m, n, k, 1, width, width, 0.0)
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
            add_gradient(program, task, place, further(U, i), k, further(Vt, i * n), share, gradient)
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
