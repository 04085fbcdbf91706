"""Solutions of one target: which are distinct, and in which order they are preferred."""

from __future__ import annotations

import math

from robust_ik.kernels.chain.full_turns import unwound
from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import NONE, ONE, W8, W16, Pointer, further, sizes, stack
from robust_ik.kernels.matrices.jacobi_rotations import ALL, orthogonalise
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kernels.pose.damped_step import columns
from robust_ik.kernels.pose.newton_polish import ROOM, SIX, TWELVE, look
from robust_ik.kernels.pose.starts.random_values import within

MOST_FOUND = sizes(lay.MOST_FOUND)


@inlined
def apart(problem: Pointer, a: Pointer, b: Pointer) -> float:
    """The largest difference of two configurations in any joint, modulo full turns, rad or m."""
    largest = 0.0
    for j in range(int(problem[lay.COUNT])):
        d = a[j] - b[j]
        if problem[lay.HEAD + j * lay.STRIDE + lay.PERIODIC] > 0.0:
            d = unwound(d)
        largest = max(largest, abs(d))
    return largest


@called
def unwind(problem: Pointer, options: Pointer, values: Pointer, q0: Pointer) -> None:
    """Removes full turns: values as close as possible to q0, or to the middle of the limits if that is preferred."""
    for j in range(int(problem[lay.COUNT])):
        at = lay.HEAD + j * lay.STRIDE
        if problem[at + lay.PERIODIC] > 0.0:
            middle = 0.5 * (problem[at + lay.LOWER] + problem[at + lay.UPPER])
            centred = options[lay.PREFER] == lay.LIMITS and abs(middle) < math.inf
            values[j] = within(problem, j, values[j], middle if centred else q0[j])


@called
def is_new(problem: Pointer, options: Pointer, values: Pointer, found: Pointer, count: int, length: int) -> bool:
    """Whether a solution differs from the `count` earlier ones, rows of `length`."""
    least = math.inf
    for s in range(count):
        least = min(least, apart(problem, values, further(found, s * length)))
    return bool(least >= options[lay.APART])


@called
def cost(problem: Pointer, options: Pointer, values: Pointer, q0: Pointer, target: Pointer) -> float:
    """The cost by which solutions are ordered: the smaller, the better."""
    prefer, total = options[lay.PREFER], 0.0
    if prefer == lay.NEAREST:
        for j in range(int(problem[lay.COUNT])):
            total += (values[j] - q0[j]) ** 2
        return total
    if prefer == lay.LIMITS:
        return -margin(problem, values)
    return 0.0 if prefer == lay.ANY else -least_singular_value(problem, options, values, target)


@called
def margin(problem: Pointer, values: Pointer) -> float:
    """The least distance of any joint to its limits, as a fraction of half its range."""
    least = 1.0
    for j in range(int(problem[lay.COUNT])):
        at = lay.HEAD + j * lay.STRIDE
        low, high = problem[at + lay.LOWER], problem[at + lay.UPPER]
        room = min(values[j] - low, high - values[j])
        half = 0.5 * (high - low)
        if room < math.inf and half > 0.0:
            least = min(least, room / half if half < math.inf else room / (1.0 + room))
    return least


@called
def least_singular_value(problem: Pointer, options: Pointer, values: Pointer, target: Pointer) -> float:
    """The least singular value of the Jacobian in the wanted rows, angular rows times the length scale."""
    k, m = int(problem[lay.COUNT]), 0
    axes, end, error = stack(0.0, ROOM, SIX), stack(0.0, ONE, TWELVE), stack(0.0, ONE, TWELVE)
    J, A, norms = stack(0.0, W16, W8), stack(0.0, W16, W16), stack(0.0, ONE, W16)
    look(problem, values, target, axes, end, error)
    error[8], error[9], error[10], error[11] = 1.0, 0.0, 0.0, 0.0
    columns(problem, axes, end, error, options[lay.SCALE], J, 0.0)
    for x in range(256):
        A[x] = 0.0
    for r in range(6):
        if problem[lay.ROWS + r] > 0.0:
            for j in range(k):
                A[16 * m + j] = J[8 * j + r]
            m += 1
    if m > k:
        for i in range(m):
            for j in range(i):
                A[16 * i + j], A[16 * j + i] = A[16 * j + i], A[16 * i + j]
    count = min(m, k)
    orthogonalise(A, A, count, W16, NONE, norms, ALL, 0.0)
    least = math.inf
    for i in range(count):
        least = min(least, norms[i])
    return math.sqrt(least)


@called
def arrange(problem: Pointer, options: Pointer, found: Pointer, count: int, q0: Pointer, target: Pointer) -> None:
    """Sorts solutions in the order of preference."""
    length = int(problem[lay.LENGTH])
    costs = stack(0.0, ONE, MOST_FOUND)
    if count < 2 or options[lay.PREFER] == lay.ANY:
        return
    for s in range(count):
        costs[s] = cost(problem, options, further(found, s * length), q0, target)
    for s in range(count):
        best = s
        for t in range(s + 1, count):
            if costs[t] < costs[best]:
                best = t
        costs[s], costs[best] = costs[best], costs[s]
        for x in range(length):
            a, b = s * length + x, best * length + x
            found[a], found[b] = found[b], found[a]


@called
def write_configuration(problem: Pointer, q0: Pointer, q: Pointer) -> None:
    """Turns joint values at the beginning of q into a configuration; joints that do not move the frame are as in q0."""
    k = int(problem[lay.COUNT])
    values = stack(0.0, ONE, W16)
    for j in range(k):
        values[j] = q[j]
    for x in range(int(problem[lay.LENGTH])):
        q[x] = q0[x]
    for j in range(k):
        at = lay.HEAD + j * lay.STRIDE
        place = int(problem[at + lay.PLACE])
        if problem[at + lay.CIRCLE] > 0.0:
            q[place], q[place + 1] = math.cos(values[j]), math.sin(values[j])
        else:
            q[place] = values[j]


@called
def read_configuration(problem: Pointer, q: Pointer, values: Pointer) -> None:
    """Reads the values of the joints that move the frame."""
    for j in range(int(problem[lay.COUNT])):
        at = lay.HEAD + j * lay.STRIDE
        place = int(problem[at + lay.PLACE])
        values[j] = math.atan2(q[place + 1], q[place]) if problem[at + lay.CIRCLE] > 0.0 else q[place]
