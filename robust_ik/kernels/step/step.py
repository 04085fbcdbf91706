"""A control step: joint velocities from q and a twist, for one configuration or eight at a time."""

from __future__ import annotations

import math

from robust_ik.checks import Array
from robust_ik.kernels.chain.chain_layout import CONFIGURATION, INDEPENDENT
from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.simd_lanes import COUNT, spread
from robust_ik.kernels.compiler.stack_memory import ONE, W8, Pointer, Sizes, each_lane, further, pointer, stack
from robust_ik.kernels.matrices.jacobi_rotations import ALL, orthogonalise
from robust_ik.kernels.step import step_layout as slots
from robust_ik.kernels.step.step_layout import DONE, TOO_LARGE
from robust_ik.kernels.step.step_solving import ROUNDING, WELL_DAMPED, add_beside, combine, damped, order_of, weigh
from robust_ik.kernels.step.step_task import check, scale_rows, task


@called
def step_one(
    program: Pointer, q: Pointer, twist: Pointer, beside: Pointer, wanted: bool, out: Pointer, width: Sizes
) -> int:
    """One step, with a secondary joint velocity `beside` in the null space if `wanted`."""
    P, m = len(width), int(program[slots.ROWS])
    chain, factors = further(program, int(program[slots.CHAIN])), further(program, int(program[slots.JOINTS]))
    n = int(chain[INDEPENDENT])
    J, x, found, more = stack(0.0, W8, width), stack(0.0, ONE, W8), stack(0.0, ONE, width), stack(0.0, ONE, width)
    squares, y = stack(0.0, ONE, W8), stack(0.0, ONE, W8)
    status = check(program, q, twist)
    if status != DONE:
        return status
    task(program, q, twist, 1, J, x, width, 0.0)
    poor = True
    if program[slots.METHOD] == slots.DAMPED and not wanted:
        trace = damped(J, x, m, program[slots.DAMPING], found, width, 0.0)
        poor = not program[slots.DAMPING] >= WELL_DAMPED * trace
    if poor:
        # For four joints, two of six rows are rounding errors; they matter only to a secondary motion.
        orthogonalise(J, x, m, width, ONE, squares, ROUNDING if m > n and not wanted else ALL, 0.0)
        weigh(program, squares, x, y, m, min(m, n), 0, 1)
        combine(J, y, m, found, width, 0.0)
    if wanted:
        for c in range(P):
            more[c] = beside[c] if c < n else 0.0
        if program[slots.JOINTS] > 0.0:
            scale_rows(further(factors, n * n), n, more, 1, 0.0)
        add_beside(J, squares, m, min(m, n), more, found, width)
    if program[slots.JOINTS] > 0.0:
        scale_rows(factors, n, found, 1, 0.0)
    return store(found, out, n, 0, 1)


@inlined
def store(found: Pointer, out: Pointer, n: int, lane: int, lanes: int) -> int:
    """Writes joint velocities; TOO_LARGE if they are not finite, else DONE."""
    total = 0.0
    for c in range(n):
        value = found[c * lanes + lane]
        out[c] = value
        total += value * 0.0
    return TOO_LARGE if math.isnan(total) else DONE


@called
def factor_one(program: Pointer, q: Pointer, twist: Pointer, s: Pointer, x: Pointer, Vt: Pointer, width: Sizes) -> int:
    """Fills σᵢ, uᵢᵀẋ and vᵢ of the scaled task, the largest σ first, for a filter that is not compiled."""
    P, m = len(width), int(program[slots.ROWS])
    n = int(program[int(program[slots.CHAIN]) + INDEPENDENT])
    J, wanted, squares, order = stack(0.0, W8, width), stack(0.0, ONE, W8), stack(0.0, ONE, W8), stack(0.0, ONE, W8)
    status = check(program, q, twist)
    if status != DONE:
        return status
    task(program, q, twist, 1, J, wanted, width, 0.0)
    orthogonalise(J, wanted, m, width, ONE, squares, ALL, 0.0)
    order_of(squares, order, m, 0, 1)
    for index in range(min(m, n)):
        i = int(order[index])
        s[index], x[index] = math.sqrt(squares[i]), wanted[i]
        for c in range(n):
            Vt[index * n + c] = J[i * P + c] / s[index] if s[index] > 0.0 else 0.0
    return DONE


@called
def step_eight(program: Pointer, q: Pointer, twist: Pointer, out: Pointer, width: Sizes) -> int:
    """COUNT steps side by side; returns the worst status."""
    zero = spread(0.0)
    m, chain = int(program[slots.ROWS]), further(program, int(program[slots.CHAIN]))
    n, nq = int(chain[INDEPENDENT]), int(chain[CONFIGURATION])
    J, x, found = stack(zero, W8, width), stack(zero, ONE, W8), stack(zero, ONE, width)
    squares, y, poor = stack(zero, ONE, W8), stack(zero, ONE, W8), stack(zero, ONE, ONE)
    for lane in range(COUNT):
        status = check(program, further(q, lane * nq), further(twist, lane * m))
        if status != DONE:
            return status
    task(program, q, twist, COUNT, J, x, width, zero)
    poor[0] = zero
    if program[slots.METHOD] == slots.DAMPED:
        trace = damped(J, x, m, program[slots.DAMPING], found, width, zero)
        poor[0] = WELL_DAMPED * trace - program[slots.DAMPING]
    else:
        orthogonalise(J, x, m, width, ONE, squares, ROUNDING if m > n else ALL, zero)
        for lane in range(COUNT):
            weigh(program, each_lane(squares), each_lane(x), each_lane(y), m, min(m, n), lane, COUNT)
        combine(J, y, m, found, width, zero)
    if program[slots.JOINTS] > 0.0:
        scale_rows(further(program, int(program[slots.JOINTS])), n, found, 1, zero)
    worst, doubtful = DONE, each_lane(poor)
    for lane in range(COUNT):
        target = further(out, lane * n)
        if doubtful[lane] > 0.0:
            status = step_one(program, further(q, lane * nq), further(twist, lane * m), q, False, target, width)
        else:
            status = store(each_lane(found), target, n, lane, COUNT)
        worst = max(worst, status)
    return worst


@inlined
def many(program: Pointer, q: Array, twist: Array, beside: Array, out: Array, width: Sizes) -> int:
    """A step for each row; returns the first status that is not DONE."""
    wanted, done = beside.shape[0] > 0, 0
    n, nq, m = out.shape[1], q.shape[1], twist.shape[1]
    from_q, from_twist, from_beside, to = pointer(q), pointer(twist), pointer(beside), pointer(out)
    while not wanted and len(q) - done >= COUNT:
        at_q, at_twist, at = further(from_q, done * nq), further(from_twist, done * m), further(to, done * n)
        status = step_eight(program, at_q, at_twist, at, width)
        if status != DONE:
            return status
        done += COUNT
    for e in range(done, len(q)):
        status = step_one(
            program, further(from_q, e * nq), further(from_twist, e * m), further(from_beside, e * n), wanted,
            further(to, e * n), width,
        )  # fmt: skip
        if status != DONE:
            return status
    return DONE
