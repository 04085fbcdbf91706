"""The joint velocities from which a resolver starts: the compiled form of `within_bounds.feasible_start`.

That has the reasons. Its quadratic program, in the velocities and in what each row below its floor still lacks, becomes
a projection: √PRICE q̇ and what is lacking are its unknowns.
"""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.simd_lanes import Number
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, further, sizes, stack
from robust_ik.kernels.matrices.small_products import dot
from robust_ik.kernels.within_bounds.bounds_layout import UNKNOWNS
from robust_ik.kernels.within_bounds.polyhedron_projection import ROOM, nearest_inside

PRICE = 0.1
"""As `feasible_start.PRICE`."""
ROUNDS = 10
"""As `feasible_start.ROUNDS`."""
INSIDE = 1e-12
"""As `feasible_start.INSIDE`."""
SHORT = 0.5e-9
"""A row below its floor by more than this is not kept; half of `bounds.CONTRADICTION`, as in `feasible_start`."""
ROWS = sizes(UNKNOWNS)
"""Room for the rows below their floors."""


@inlined
def clip(value: Number, lower: Number, upper: Number) -> Number:
    """The nearest value between the bounds."""
    return min(max(value, lower), upper)


@called
def feasible_start(
    rows: Pointer, floor: Pointer, yielded: Pointer, count: int, lower: Pointer, upper: Pointer, near: Pointer, n: int,
    mark: float, scratch: Pointer, qdot: Pointer,
) -> bool:  # fmt: skip
    """Fills in velocities inside the box with rows · q̇ ≥ floor, as close to that as they can come.

    Args:
        rows: Rows, (count, n).
        floor: The least values of the rows' products with q̇; those that are missed are lowered to what is reached.
        yielded: Where `mark` is added for every row that misses its floor, (count,).
        count: Number of rows.
        lower: The box.
        upper: The box.
        near: Velocities to be close to, (n,).
        n: Number of joints.
        mark: See `yielded`.
        scratch: Room for `scratch_of(n, count)` numbers.
        qdot: (n,), filled.

    Returns:
        False if there are more rows below their floors than there is room for; then nothing but `qdot` has changed.
    """
    below, short = stack(0.0, ONE, ROWS), 0
    for c in range(n):
        qdot[c] = clip(near[c], lower[c], upper[c])
    for r in range(count):
        if dot(further(rows, r * n), qdot, n) < floor[r] - SHORT:
            if short == UNKNOWNS - n:
                return False
            below[short] = float(r)
            short += 1
    if short == 0:
        return True
    raise_rows(rows, floor, count, lower, upper, near, n, below, short, scratch, qdot)
    for r in range(count):
        reached = dot(further(rows, r * n), qdot, n)
        if reached < floor[r] - SHORT:
            yielded[r] += mark
        floor[r] = min(floor[r], reached)
    return True


@called
def raise_rows(
    rows: Pointer, floor: Pointer, count: int, lower: Pointer, upper: Pointer, near: Pointer, n: int, below: Pointer,
    short: int, scratch: Pointer, qdot: Pointer,
) -> None:  # fmt: skip
    """Moves q̇ so that the rows below their floors come close to them: some rounds of proximal multipliers."""
    d, root = n + short, math.sqrt(PRICE)
    unit = scratch
    target = further(unit, count * n)
    asked = further(target, count)
    normals = further(asked, count)
    space = further(normals, (n + count + 2 * short) * d)
    worst, lack = stack(0.0, ONE, ROWS), stack(0.0, ONE, ROWS)
    wanted, y = stack(0.0, ONE, ROOM), stack(0.0, ONE, ROOM)
    for r in range(count):
        size = math.sqrt(dot(further(rows, r * n), further(rows, r * n), n))
        size = size if size > 0.0 else 1.0
        for c in range(n):
            unit[r * n + c] = rows[r * n + c] / size
        target[r] = floor[r] / size
        asked[r] = min(target[r], dot(further(unit, r * n), qdot, n))
    for i in range(short):
        r = int(below[i])
        worst[i], asked[r] = asked[r], target[r]
    for _ in range(ROUNDS):
        for i in range(short):
            r = int(below[i])
            lack[i] = max(asked[r] - dot(further(unit, r * n), qdot, n), 0.0)
        constrain_rows(unit, asked, count, lower, upper, n, below, short, worst, lack, qdot, normals, space)
        for c in range(n):
            wanted[c] = root * (near[c] - qdot[c])
        for i in range(short):
            wanted[n + i] = -lack[i]
        nearest_inside(normals, space, n, count + 2 * short, d, wanted, y)
        for c in range(n):
            qdot[c] = clip(qdot[c] + y[c] / root, lower[c], upper[c])
        kept = True
        for i in range(short):
            r = int(below[i])
            reached = dot(further(unit, r * n), qdot, n)
            kept &= reached >= target[r] - INSIDE
            asked[r] = target[r] + max(asked[r] - reached, 0.0)
        if kept:
            break


@called
def constrain_rows(
    unit: Pointer, asked: Pointer, count: int, lower: Pointer, upper: Pointer, n: int, below: Pointer, short: int,
    worst: Pointer, lack: Pointer, qdot: Pointer, normals: Pointer, space: Pointer,
) -> None:  # fmt: skip
    """Fills in the rows of a round and their room from where it begins: q̇, and what is lacking of the rows below.

    The box; no row below what is asked for but by what it lacks; no row lower than it was; nothing lacks less than 0.
    """
    d, root, rows = n + short, math.sqrt(PRICE), n + count + 2 * short
    for i in range(rows * d):
        normals[i] = 0.0
    for c in range(n):
        normals[c * d + c] = 1.0 / root
        space[c], space[n + c] = upper[c] - qdot[c], qdot[c] - lower[c]
    for r in range(count):
        for c in range(n):
            normals[(n + r) * d + c] = -unit[r * n + c] / root
        space[2 * n + r] = max(dot(further(unit, r * n), qdot, n) - asked[r], 0.0)
    for i in range(short):
        r, first, second = int(below[i]), n + count + i, n + count + short + i
        normals[(n + r) * d + n + i] = -1.0
        reached = dot(further(unit, r * n), qdot, n)
        space[2 * n + r] = max(reached + lack[i] - asked[r], 0.0)
        for c in range(n):
            normals[first * d + c] = -unit[r * n + c] / root
        space[n + first] = max(reached - worst[i], 0.0)
        normals[second * d + n + i] = -1.0
        space[n + second] = lack[i]
