"""The compiled form of `inverses.second_order.turning`: what is remembered of a turn, and the motion that it adds."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, stack
from robust_ik.kernels.matrices.small_products import dot, multiply_transposed
from robust_ik.kernels.matrices.symmetric_eigenvectors import diagonalise
from robust_ik.kernels.second_order import second_order_layout as lay
from robust_ik.kernels.second_order.quartic import bend_along, served_by
from robust_ik.kernels.second_order.weak_motion import chosen_side, joint_motion
from robust_ik.kernels.second_order.weak_rows import largest_of, matrix_of, motion_of, norm, vector_of


@inlined
def within(value: float, least: float, most: float) -> float:
    """The value, or the end of the range that it is beyond."""
    return min(max(value, least), most)


@inlined
def way_of(memory: Pointer, n: int) -> Pointer:
    """The joint motion of the turn, (n,)."""
    return further(memory, lay.LAST + n)


@called
def forget(memory: Pointer) -> None:
    """Forgets the turn."""
    memory[lay.WAITED], memory[lay.PROGRESSED], memory[lay.TURNED] = 0.0, 0.0, 0.0
    memory[lay.HAS_WAY], memory[lay.HAS_ASKED] = 0.0, 0.0


@called
def gain(memory: Pointer) -> float:
    """From 1 over 0 to −1 and 0: grows after some patience, changes sides once, ends."""
    patience = within(memory[lay.WAITED] / lay.PATIENCE - 1.0, 0.0, 1.0)
    side = within((lay.HALF_TURN - memory[lay.TURNED]) / lay.EASE, -1.0, 1.0)
    return patience * side * within((3.0 * lay.HALF_TURN - memory[lay.TURNED]) / lay.EASE, 0.0, 1.0)


@called
def note(memory: Pointer, x: Pointer, m: int, n: int, share: float, curvature: float, dt: float) -> None:
    """Moves the memory on by a step; see `turning.Turn.after`."""
    asked, size = further(memory, lay.LAST + 2 * n), norm(x, m)
    if size > 0.0:
        if memory[lay.HAS_ASKED] > 0.0 and not dot(x, asked, m) / size > lay.OTHER:
            forget(memory)
        if memory[lay.HAS_ASKED] == 0.0:
            memory[lay.HAS_ASKED] = 1.0
            for i in range(m):
                asked[i] = x[i] / size
    if share > lay.SERVED and (memory[lay.HAS_WAY] > 0.0 or curvature < lay.FLAT):
        memory[lay.WAITED] = min(memory[lay.WAITED] + dt, 2.0 * lay.PATIENCE)
        memory[lay.PROGRESSED] = 0.0
        return
    memory[lay.WAITED] = max(0.0, memory[lay.WAITED] - dt)
    if share <= lay.SERVED:
        memory[lay.PROGRESSED] += dt
    if memory[lay.PROGRESSED] > lay.SETTLED:
        forget(memory)


@called
def unserved(sheet: Pointer, z: Pointer, width: Sizes) -> float:
    """The share of the weak command that a kernel motion leaves over."""
    k, command = int(sheet[lay.WEAK]), vector_of(sheet, lay.COMMAND, width)
    bent, served = stack(0.0, width, width), stack(0.0, ONE, width)
    bend_along(sheet, z, bent, width)
    served_by(sheet, z, bent, served, width)
    for i in range(k):
        served[i] = command[i] - served[i]
    return norm(served, k) / max(norm(command, k), lay.TINY)


@called
def fastest_turn(sheet: Pointer, way: Pointer, width: Sizes) -> float:
    """Fills in the kernel motion, (p,), of length 1, that turns the lost command fastest; returns how fast, 1/rad."""
    r, p, T = int(sheet[lay.KEPT]), int(sheet[lay.FREE]), matrix_of(sheet, lay.TURNING, width)
    square, values, vectors = stack(0.0, width, width), stack(0.0, ONE, width), stack(0.0, width, width)
    multiply_transposed(T, r, p, T, p, square)
    diagonalise(square, p, values, vectors)
    highest = 0
    for a in range(1, p):
        highest = a if values[a] > values[highest] else highest
    for a in range(p):
        way[a] = vectors[highest * p + a]
    return math.sqrt(max(values[highest], 0.0))


@called
def add_turn(memory: Pointer, sheet: Pointer, n: int, parameters: Pointer, z: Pointer, width: Sizes) -> None:
    """Adds the turn to the kernel motion z, (p,), if something is to be turned; see `turning.Turn.added`.

    Args:
        memory: Moved on.
        sheet: With the quartic.
        n: Number of joints.
        parameters: See `second_order_layout`.
        z: (p,).
        width: At least n.
    """
    k, p, speed = int(sheet[lay.WEAK]), int(sheet[lay.FREE]), parameters[lay.TURN_SPEED]
    share = within((unserved(sheet, z, width) - lay.SERVED) / (lay.UNSERVED - lay.SERVED), 0.0, 1.0)
    share *= sheet[lay.FADE] * within((sheet[lay.ASKED] - lay.DEAD) / (lay.BRISK - lay.DEAD), 0.0, 1.0)
    if share <= 0.0 or memory[lay.WAITED] <= lay.PATIENCE or sheet[lay.KEPT] == 0.0:
        return
    direction, motion, way = stack(0.0, ONE, width), stack(0.0, ONE, width), way_of(memory, n)
    share *= within(fastest_turn(sheet, direction, width) / lay.LEAST_TURN - 1.0, 0.0, 1.0)
    if share <= 0.0:
        return
    joint_motion(sheet, direction, n, motion, width)
    if memory[lay.HAS_WAY] == 0.0:
        first = progress(sheet, matrix_of(sheet, lay.CROSS, width), direction, width) / sheet[lay.ASKED]
        side = chosen_side(0.0, first * speed, motion, n, speed)
    else:
        side = -1.0 if dot(way, motion, n) < 0.0 else 1.0
    now = gain(memory)
    memory[lay.HAS_WAY] = 1.0
    memory[lay.TURNED] += max(abs(now), lay.SLOWEST) * share * speed * parameters[lay.DT]
    towards = 1.0 if now > 0.0 else -1.0 if now < 0.0 else 0.0
    for c in range(n):
        way[c] = side * motion[c]
    for a in range(p):
        direction[a] = towards * dot(motion_of(sheet, a, n, width), way, n)
    size = share * abs(now) * speed / largest_of(way, n)
    command = vector_of(sheet, lay.COMMAND, width)
    wrong = -progress(sheet, matrix_of(sheet, lay.SLOPE, width), direction, width)
    wrong /= max(norm(command, k), lay.TINY)
    if wrong > 0.0:
        size = min(size, lay.AGAINST * sheet[lay.ASKED] / wrong)
    more = max(0.0, size - max(0.0, dot(direction, z, p)))
    for a in range(p):
        z[a] += more * direction[a]


@called
def progress(sheet: Pointer, A: Pointer, z: Pointer, width: Sizes) -> float:
    """The progress c · A z along the command, for A of shape (k, p)."""
    p, total = int(sheet[lay.FREE]), 0.0
    for i in range(int(sheet[lay.WEAK])):
        total += vector_of(sheet, lay.COMMAND, width)[i] * dot(further(A, i * p), z, p)
    return total
