"""Finds the closest pose near a configuration: Newton's method on E within limits.

Joints at a limit that are pushed outwards stay; a step that does not lower E is taken again with more damping.

Source: Bertsekas 1982 for the limits.
"""

from __future__ import annotations

from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import ONE, W8, W16, Pointer, sizes, stack
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kernels.pose.damped_step import step
from robust_ik.kernels.pose.error_hessian import curvature
from robust_ik.kernels.pose.pose_error import measure

ROUNDS = 40
"""Most steps, rejected ones included. Chosen: near a minimum few are needed; others wait for the damping."""
ENOUGH = 1e-10
"""Relative decrease of E below which the iteration ends."""
NEARLY, DESCENT = 1e-6, 200
"""E below which damped least squares continue, and most steps of it: singular solutions take many (`descend`)."""
PATIENCE, ALMOST = 20, 1e-14
"""In this many of these steps E must fall to half, as long as it is above ALMOST."""
LEAST, MOST = 1e-12, 1e8
"""Least and largest damping. Chosen: the least hardly changes a step, the largest leaves hardly any."""
SHIFT = 1e-2
"""Times E: the least damping if the second derivative is not positive definite."""
ROOM, SIX, TWELVE = sizes(lay.MOST_CHAIN), sizes(6), sizes(12)


@called
def newton_step(H: Pointer, g: Pointer, free: Pointer, damping: float, k: int, d: Pointer) -> bool:
    """Solves (H + damping) d = g for the joints that are free; False if that matrix is not positive definite."""
    A, D = stack(0.0, W16, W16), stack(0.0, ONE, W16)
    for i in range(k):
        for j in range(i + 1):
            together = free[i] * free[j]
            A[16 * i + j] = H[16 * i + j] * together
        A[17 * i] += damping if free[i] > 0.0 else 1.0
        d[i] = g[i] * free[i]
    for j in range(k):
        pivot = A[17 * j]
        for c in range(j):
            pivot -= A[16 * j + c] ** 2 * D[c]
        if not pivot > 1e-3 * damping:
            return False
        D[j] = pivot
        for i in range(j + 1, k):
            entry = A[16 * i + j]
            for c in range(j):
                entry -= A[16 * i + c] * A[16 * j + c] * D[c]
            A[16 * i + j] = entry / pivot
    for i in range(k):
        for c in range(i):
            d[i] -= A[16 * i + c] * d[c]
    for i in range(k):
        d[i] /= D[i]
    for back in range(k):
        i = k - 1 - back
        for c in range(i + 1, k):
            d[i] -= A[16 * c + i] * d[c]
    return True


@called
def polish(problem: Pointer, options: Pointer, values: Pointer, target: Pointer, error: Pointer) -> int:
    """Moves values to the nearest minimum of E within limits and measures the error; returns the number of steps."""
    k, scale = int(problem[lay.COUNT]), options[lay.SCALE]
    axes, end = stack(0.0, ROOM, SIX), stack(0.0, ONE, TWELVE)
    H, g, d = stack(0.0, W16, W16), stack(0.0, ONE, W16), stack(0.0, ONE, W16)
    free, trial = stack(0.0, ONE, W16), stack(0.0, ONE, W16)
    look(problem, values, target, axes, end, error)
    E, damping, rounds, renew = error[6] + scale * scale * error[7], 1e-4, 0, True
    while rounds < ROUNDS and damping < MOST:
        if renew:
            curvature(problem, axes, end, target, error, scale, H, g)
            for j in range(k):
                at = lay.HEAD + j * lay.STRIDE
                out = (values[j] <= problem[at + lay.LOWER] and g[j] <= 0.0) or (
                    values[j] >= problem[at + lay.UPPER] and g[j] >= 0.0
                )
                free[j] = 0.0 if out else 1.0
            renew = False
        rounds += 1
        if not newton_step(H, g, free, damping, k, d):
            damping = max(8.0 * damping, SHIFT * E)
            continue
        for j in range(k):
            at = lay.HEAD + j * lay.STRIDE
            trial[j] = min(max(values[j] + d[j], problem[at + lay.LOWER]), problem[at + lay.UPPER])
        look(problem, trial, target, axes, end, error)
        now = error[6] + scale * scale * error[7]
        if not now < E:
            damping *= 8.0
            if E - now > -ENOUGH * E:
                break
            continue
        fell = E - now
        for j in range(k):
            values[j] = trial[j]
        E, renew, damping = now, True, max(damping * 0.1, LEAST)
        if reached(options, error) or fell < ENOUGH * E:
            break
    look(problem, values, target, axes, end, error)
    if E < NEARLY and not reached(options, error):
        rounds += descend(problem, options, values, target, axes, end, error)
    return rounds


@called
def descend(
    problem: Pointer, options: Pointer, values: Pointer, target: Pointer, axes: Pointer, end: Pointer, error: Pointer
) -> int:
    """Continues with damped least squares and keeps the values with the least E; returns the number of steps.

    Towards a singular solution E falls slowly, and not at every step; Newton's method stops there.
    """
    k, scale = int(problem[lay.COUNT]), options[lay.SCALE]
    trial, J, moving = stack(0.0, ONE, W16), stack(0.0, W16, W8), stack(0.0, ONE, ONE)
    moving[0], E, steps = 1.0, error[6] + scale * scale * error[7], 0
    before = 2.0 * E
    for j in range(k):
        trial[j] = values[j]
    while steps < DESCENT and not reached(options, error):
        step(problem, trial, axes, end, error, scale, J, moving, 0.0)
        look(problem, trial, target, axes, end, error)
        steps += 1
        now = error[6] + scale * scale * error[7]
        if now < E:
            E = now
            for j in range(k):
                values[j] = trial[j]
        if steps % PATIENCE == 0:
            if max(0.5 * before, ALMOST) < E:
                break
            before = E
    look(problem, values, target, axes, end, error)
    return steps


@inlined
def reached(options: Pointer, error: Pointer) -> bool:
    """Whether an error is within tolerances."""
    p, r = options[lay.POSITION_TOLERANCE], options[lay.ROTATION_TOLERANCE]
    return bool(error[6] <= p * p and error[7] <= r * r)


@called
def look(problem: Pointer, values: Pointer, target: Pointer, axes: Pointer, end: Pointer, error: Pointer) -> None:
    """Runs `measure` for one configuration."""
    motions, cosines, sines = stack(0.0, ONE, ROOM), stack(0.0, ONE, ROOM), stack(0.0, ONE, ROOM)
    for i in range(len(ROOM)):
        motions[i] = 0.0
    measure(problem, values, target, motions, cosines, sines, axes, end, error, 0.0)
