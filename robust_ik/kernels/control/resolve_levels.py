"""The walk down the levels: the compiled form of `priority_resolver` and of `acceleration_ramp`."""

from __future__ import annotations

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.simd_lanes import Number, where
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.calming import asked_share
from robust_ik.kernels.control.level_fit import fit, largest_step, slowed
from robust_ik.kernels.control.level_freedom import (
    VECTOR,
    found_of,
    length_of,
    level_motion,
    project,
    record_of,
    reduce,
    steady,
)
from robust_ik.kernels.control.reconstructed_motion import reconstructed
from robust_ik.kernels.control.second_order_motion import curved_motion, is_finite
from robust_ik.kernels.matrices.small_products import dot
from robust_ik.kernels.within_bounds.feasible_start import clip, feasible_start


@called
def start_inside(program: Pointer, desk: Pointer, lower: Pointer, upper: Pointer, near: Pointer, mark: float) -> bool:
    """Puts QDOT inside the bounds, close to `near`, and lowers floors that are missed; False where NumPy has to."""
    n, count = int(program[slots.JOINTS]), int(program[slots.ROWS])
    qdot, floor = further(desk, int(program[slots.QDOT])), further(desk, int(program[slots.FLOOR]))
    told, yielded = further(floor, count), further(floor, 2 * count)
    for r in range(count):
        if mark == slots.FIRST_STAGE:
            told[r], yielded[r] = floor[r], 0.0
        else:
            floor[r] = told[r]
    return bool(
        feasible_start(
            further(desk, int(program[slots.BOUND_ROWS])), floor, yielded, count, lower, upper, near, n, mark,
            further(desk, int(program[slots.SCRATCH])), qdot,
        )
    )  # fmt: skip


@called
def missing_of(
    program: Pointer, desk: Pointer, level: int, share: Number, qdot: Pointer, missing: Pointer
) -> None:  # fmt: skip
    """Fills in share · ẋ − J q̇ of a level."""
    record, n = record_of(program, level), int(program[slots.JOINTS])
    x, J = further(desk, int(record[slots.X])), further(desk, int(record[slots.JACOBIAN]))
    for r in range(int(record[slots.M])):
        missing[r] = share * x[r] - dot(further(J, r * n), qdot, n)


@called
def wish(program: Pointer, desk: Pointer, level: int, given: bool, length: Pointer, width: Sizes) -> bool:
    """Fills MOTION with what one level wants to add to QDOT, and `length` with ‖what it misses‖.

    False if its motion has to come from outside, and is not given yet.
    """
    record, qdot = record_of(program, level), further(desk, int(program[slots.QDOT]))
    missing = further(desk, int(record[slots.MISSING]))
    if not given:
        reduce(program, desk, level, width)
        missing_of(program, desk, level, asked_share(program, desk), qdot, missing)
        if record[slots.WAY] == slots.OUTSIDE:
            return False
        if record[slots.WAY] == slots.RECONSTRUCTED:
            reconstructed(program, desk, level, width)
        elif record[slots.WAY] >= slots.CURVED:
            curved_motion(program, desk, level, width)
        else:
            level_motion(program, desk, level, width)
    else:
        project(program, desk, level, further(desk, int(program[slots.MOTION])))
    length[0] = length_of(missing, int(record[slots.M]))
    if program[slots.STEADY] > 0.0:
        steady(program, desk, level, missing, length)
    return True


@called
def move_on(program: Pointer, desk: Pointer, level: int, change: Pointer) -> None:
    """Moves QDOT on by the change that a level gets, slowed further if it has been stopped."""
    qdot, motion = further(desk, int(program[slots.QDOT])), further(desk, int(program[slots.MOTION]))
    lower, upper = further(desk, int(program[slots.LONG_LOWER])), further(desk, int(program[slots.LONG_UPPER]))
    aim = further(desk, int(record_of(program, level)[slots.AIM]))
    if program[slots.RISE] > 0.0:
        ease(program, desk, level, motion, change)
    for c in range(int(program[slots.JOINTS])):
        qdot[c] = clip(qdot[c] + change[c], lower[c], upper[c])
        aim[c] = qdot[c]


@called
def resolve_level(program: Pointer, desk: Pointer, level: int, given: bool, width: Sizes) -> bool:
    """Moves QDOT on by what one level gets; False if its motion has to come from outside, and is not given yet."""
    change, length = stack(0.0, ONE, VECTOR), stack(0.0, ONE, ONE)
    if not wish(program, desk, level, given, length, width):
        return False
    qdot, motion = further(desk, int(program[slots.QDOT])), further(desk, int(program[slots.MOTION]))
    lower, upper = further(desk, int(program[slots.LONG_LOWER])), further(desk, int(program[slots.LONG_UPPER]))
    found_of(program, desk, level)[slots.SHARE] = fit(
        program, desk, level, lower, upper, qdot, program[slots.DT] * length[0], motion, change
    )
    move_on(program, desk, level, change)
    return True


@called
def ease(program: Pointer, desk: Pointer, level: int, motion: Pointer, change: Pointer) -> None:
    """Slows a level that has been stopped, so that its speed rises slowly; see `limiters.Eased`."""
    n, speeds, found = (
        int(program[slots.JOINTS]),
        further(desk, int(program[slots.EASED])),
        found_of(program, desk, level),
    )
    largest, share = 0.0, found[slots.SHARE]
    for c in range(n):
        largest = max(largest, abs(motion[c]))
    soft = program[slots.DT] * (speeds[level] / slots.RISING + slots.SOFT)
    most = speeds[level] + min(program[slots.RISE], soft)
    slower = where(share * largest > most, most / (share * largest), 1.0)
    for c in range(n):
        change[c] *= slower
    found[slots.SHARE] = share * slower
    speeds[level] = where(found[slots.SHARE] >= 1.0, INFINITE, found[slots.SHARE] * largest)


EVEN = 1 + 1e-12
"""As `acceleration_ramp.EVEN`."""

INFINITE = float("inf")
"""The last speed of a level that was not slowed."""


@called
def ramp(program: Pointer, desk: Pointer) -> None:
    """Moves QDOT from its start towards the levels' aims, as fast as acceleration limits allow; see `ramped`."""
    n, levels = int(program[slots.JOINTS]), int(program[slots.LEVELS])
    lower, upper = further(desk, int(program[slots.LOWER])), further(desk, int(program[slots.UPPER]))
    qdot, start = further(desk, int(program[slots.QDOT])), stack(0.0, ONE, VECTOR)
    way, change, rest = stack(0.0, ONE, VECTOR), stack(0.0, ONE, VECTOR), stack(0.0, ONE, VECTOR)
    for level in range(levels):
        found, aim = found_of(program, desk, level), further(desk, int(record_of(program, level)[slots.AIM]))
        for c in range(n):
            rest[c], start[c] = aim[c] - qdot[c], qdot[c]
        along(program, desk, level, rest, way)
        share = fit(program, desk, level, lower, upper, qdot, 0.0, way, change)
        if level == 0 and share < 1.0:
            nearer(program, desk, lower, upper, qdot, way, change)
        for c in range(n):
            qdot[c] = clip(qdot[c] + change[c], lower[c], upper[c])
        if share != 1.0:
            found[slots.SHARE] *= reached(program, desk, level, aim, start, qdot)
    aim = further(desk, int(record_of(program, levels - 1)[slots.AIM]))
    for c in range(n):
        rest[c] = aim[c] - qdot[c]
    below(program, desk, levels - 1, rest)
    slowed(program, desk, lower, upper, qdot, rest, change)
    for c in range(n):
        qdot[c] = clip(qdot[c] + change[c], lower[c], upper[c])


@called
def along(program: Pointer, desk: Pointer, level: int, motion: Pointer, kept: Pointer) -> None:
    """Fills in the part of a motion along the directions that a level closes to lower ones."""
    n, Vt = int(program[slots.JOINTS]), further(desk, int(record_of(program, level)[slots.RIGHT]))
    for c in range(n):
        kept[c] = 0.0
    for i in range(int(found_of(program, desk, level)[slots.CLOSED])):
        share = dot(further(Vt, i * n), motion, n)
        for c in range(n):
            kept[c] += share * Vt[i * n + c]


@called
def below(program: Pointer, desk: Pointer, level: int, motion: Pointer) -> None:
    """Replaces a motion by its part in the freedom below a level."""
    n, Vt, found = int(program[slots.JOINTS]), record_of(program, level), found_of(program, desk, level)
    rows, kept = further(desk, int(Vt[slots.RIGHT])), stack(0.0, ONE, VECTOR)
    if found[slots.CLOSED] == 0.0 and int(found[slots.FREE]) == n:
        return
    for c in range(n):
        kept[c] = 0.0
    for i in range(int(found[slots.CLOSED]), int(found[slots.FREE])):
        share = dot(further(rows, i * n), motion, n)
        for c in range(n):
            kept[c] += share * rows[i * n + c]
    for c in range(n):
        motion[c] = kept[c]


@called
def nearer(
    program: Pointer, desk: Pointer, lower: Pointer, upper: Pointer, qdot: Pointer, way: Pointer, change: Pointer
) -> None:
    """Replaces the first level's change by that of every joint by itself, if it comes nearer to the aim."""
    n, Vt = int(program[slots.JOINTS]), further(desk, int(record_of(program, 0)[slots.RIGHT]))
    each = stack(0.0, ONE, VECTOR)
    for c in range(n):
        each[c] = clip(qdot[c] + way[c], lower[c], upper[c]) - qdot[c]
    share = largest_step(program, desk, lower, upper, qdot, each)
    missing, others = 0.0, 0.0
    for c in range(n):
        each[c] *= share
    for i in range(int(found_of(program, desk, 0)[slots.CLOSED])):
        row, one, other = further(Vt, i * n), 0.0, 0.0
        for c in range(n):
            one += row[c] * (way[c] - change[c])
            other += row[c] * (way[c] - each[c])
        missing += one * one
        others += other * other
    if others <= missing * EVEN * EVEN:
        for c in range(n):
            change[c] = each[c]


@called
def reached(program: Pointer, desk: Pointer, level: int, aim: Pointer, start: Pointer, qdot: Pointer) -> float:
    """The share of its aim that a level gets, or of the change to it if that is longer."""
    record, found, n = record_of(program, level), found_of(program, desk, level), int(program[slots.JOINTS])
    s, Vt = further(desk, int(record[slots.SIGMA])), further(desk, int(record[slots.RIGHT]))
    whole, change, missing = 0.0, 0.0, 0.0
    for i in range(int(found[slots.COUNT])):
        row, one, other, last = further(Vt, i * n), 0.0, 0.0, 0.0
        for c in range(n):
            one += row[c] * aim[c]
            other += row[c] * (aim[c] - start[c])
            last += row[c] * (aim[c] - qdot[c])
        whole, change, missing = whole + (s[i] * one) ** 2, change + (s[i] * other) ** 2, missing + (s[i] * last) ** 2
    size = max(whole, change) ** 0.5
    return max(0.0, 1.0 - missing**0.5 / size) if size > 0.0 else 1.0


@called
def begin(program: Pointer, desk: Pointer) -> None:
    """Puts QDOT where the levels begin: at rest, or as near to it as the box allows."""
    qdot = further(desk, int(program[slots.QDOT]))
    lower, upper = further(desk, int(program[slots.LONG_LOWER])), further(desk, int(program[slots.LONG_UPPER]))
    for c in range(int(program[slots.JOINTS])):
        qdot[c] = clip(0.0, lower[c], upper[c])


@called
def hurry(program: Pointer, desk: Pointer) -> bool:
    """Replaces QDOT by what acceleration limits allow of it; False where NumPy has to."""
    lower, upper = further(desk, int(program[slots.LOWER])), further(desk, int(program[slots.UPPER]))
    if not start_inside(
        program, desk, lower, upper, further(desk, int(program[slots.LAST])), float(slots.SECOND_STAGE)
    ):
        return False
    ramp(program, desk)
    return True


@called
def rest(n: int, qdot: Pointer) -> None:
    """Fills in zeros."""
    for c in range(n):
        qdot[c] = 0.0


@called
def resolve(program: Pointer, desk: Pointer, first: int, given: bool, width: Sizes) -> int:
    """Resolves the levels from `first` on, then ramps; returns a status.

    Starts with more rows below their floors than there is room for are UNCERTAIN: NumPy makes such a step.

    Args:
        program: See `control_layout`.
        desk: The same.
        first: The level to begin with.
        given: Whether MOTION holds the motion of that level.
        width: At least the number of joints, and of rows of every level.
    """
    levels, qdot = int(program[slots.LEVELS]), further(desk, int(program[slots.QDOT]))
    if first == 0 and not given:
        lower, upper = further(desk, int(program[slots.LONG_LOWER])), further(desk, int(program[slots.LONG_UPPER]))
        still = stack(0.0, ONE, VECTOR)
        rest(int(program[slots.JOINTS]), still)
        if not start_inside(program, desk, lower, upper, still, float(slots.FIRST_STAGE)):
            return slots.UNCERTAIN
    for level in range(first, levels):
        if not resolve_level(program, desk, level, given and level == first, width):
            return slots.WANTS_MOTION + level
    if program[slots.HURRIED] > 0.0 and not hurry(program, desk):
        return slots.UNCERTAIN
    for level in range(levels):
        missing_of(program, desk, level, 1.0, qdot, further(desk, int(record_of(program, level)[slots.RESIDUAL])))
    return slots.DONE if is_finite(program, desk) else slots.TOO_LARGE
