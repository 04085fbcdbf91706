"""Rows of tasks that lead a frame: to a pose, with a twist, or along a direction.

The compiled form of `tasks.pose_feedback`, `tasks.pose_difference`, `tasks.relative`, `tasks.twist` and
`tasks.direction`, which have the reasons.
"""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, further, sizes, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.rows.frame_motion import END, frame_place, is_measured

RIGID = 1e-6
"""As `checks.RIGID_TOLERANCE`."""
THREE, SIX, NINE, TWELVE, ROWS = sizes(3), sizes(6), sizes(9), sizes(12), sizes(6 * 32)


@called
def turn(R: Pointer, transposed: bool, vector: Pointer, at: int, step: int) -> None:
    """Replaces (v[at], v[at + step], v[at + 2 step]) by R v, or by Rᵀ v; R is row by row."""
    x, y, z = vector[at], vector[at + step], vector[at + 2 * step]
    if transposed:
        vector[at] = R[0] * x + R[3] * y + R[6] * z
        vector[at + step] = R[1] * x + R[4] * y + R[7] * z
        vector[at + 2 * step] = R[2] * x + R[5] * y + R[8] * z
    else:
        vector[at] = R[0] * x + R[1] * y + R[2] * z
        vector[at + step] = R[3] * x + R[4] * y + R[5] * z
        vector[at + 2 * step] = R[6] * x + R[7] * y + R[8] * z


@called
def turn_pose(R: Pointer, pose: Pointer) -> None:
    """Replaces a pose, rotation and origin, by the pose along the axes that are the columns of R."""
    for c in range(3):
        turn(R, True, pose, c, 3)
    turn(R, True, pose, 9, 1)


@called
def turn_rows(R: Pointer, J: Pointer, n: int) -> None:
    """Replaces linear and angular rows of J, (6, n), by those along the axes that are the columns of R."""
    for c in range(n):
        turn(R, True, J, c, n)
        turn(R, True, J, 3 * n + c, n)


@called
def read_goal(task: Pointer, goal: Pointer) -> int:
    """Fills in rotation and origin of a task's target; DONE, or NOT_FINITE or NOT_RIGID."""
    given, worst, good = further(task, slots.GOAL), 0.0, True
    for r in range(3):
        for c in range(3):
            goal[3 * r + c] = given[4 * r + c]
        goal[9 + r] = given[4 * r + 3]
    for i in range(12):
        good &= is_measured(goal[i])
    for i in range(6):
        good &= is_measured(task[slots.FORWARD + i])
    if not good:
        return slots.NOT_FINITE
    if given[12] != 0.0 or given[13] != 0.0 or given[14] != 0.0 or given[15] != 1.0:
        return slots.NOT_RIGID
    for r in range(3):
        for c in range(r + 1):
            entry = goal[3 * r] * goal[3 * c] + goal[3 * r + 1] * goal[3 * c + 1] + goal[3 * r + 2] * goal[3 * c + 2]
            worst = max(worst, abs(entry - (1.0 if r == c else 0.0)))
    determinant = (
        goal[0] * (goal[4] * goal[8] - goal[5] * goal[7])
        - goal[1] * (goal[3] * goal[8] - goal[5] * goal[6])
        + goal[2] * (goal[3] * goal[7] - goal[4] * goal[6])
    )
    return slots.NOT_RIGID if worst > RIGID or determinant < 0.0 else slots.DONE


@called
def rotation_vector(R: Pointer, vector: Pointer) -> None:
    """Fills in the logarithm of a rotation by the quaternion's largest component."""
    xx, yy, zz = R[0], R[4], R[8]
    w, x, y, z = 1.0 + xx + yy + zz, 1.0 + xx - yy - zz, 1.0 - xx + yy - zz, 1.0 - xx - yy + zz
    twice = (R[7] - R[5], R[2] - R[6], R[3] - R[1])
    xy, xz, yz = R[1] + R[3], R[2] + R[6], R[5] + R[7]
    if w >= x and w >= y and w >= z:
        row = (w, twice[0], twice[1], twice[2])
    elif x >= y and x >= z:
        row = (twice[0], x, xy, xz)
    elif y >= z:
        row = (twice[1], xy, y, yz)
    else:
        row = (twice[2], xz, yz, z)
    size = math.sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2] + row[3] * row[3])
    size = -size if row[0] < 0.0 else size
    cosine, i, j, k = row[0] / size, row[1] / size, row[2] / size, row[3] / size
    sine = math.sqrt(i * i + j * j + k * k)
    factor = 2.0 if sine < 1e-9 else 2.0 * math.atan2(sine, cosine) / sine
    vector[0], vector[1], vector[2] = factor * i, factor * j, factor * k


@called
def swing(now: Pointer, wanted: Pointer, vector: Pointer) -> None:
    """Fills in the shortest rotation that brings one unit vector to another."""
    x = now[1] * wanted[2] - now[2] * wanted[1]
    y = now[2] * wanted[0] - now[0] * wanted[2]
    z = now[0] * wanted[1] - now[1] * wanted[0]
    sine = math.sqrt(x * x + y * y + z * z)
    angle = math.atan2(sine, now[0] * wanted[0] + now[1] * wanted[1] + now[2] * wanted[2])
    factor = angle / sine if sine > 1e-12 else 1.0
    vector[0], vector[1], vector[2] = factor * x, factor * y, factor * z
    if sine <= 1e-12 and angle > 1.0:
        across = stack(0.0, ONE, SIX)
        perpendicular(wanted, across)
        for i in range(3):
            vector[i] = angle * across[i]


@called
def perpendicular(direction: Pointer, across: Pointer) -> None:
    """Fills in two unit vectors that form a right-handed frame with a unit vector."""
    x, y, z = abs(direction[0]), abs(direction[1]), abs(direction[2])
    least = 0 if x <= y and x <= z else (1 if y <= z else 2)
    for i in range(3):
        across[i] = (1.0 if i == least else 0.0) - direction[least] * direction[i]
    size = math.sqrt(across[0] * across[0] + across[1] * across[1] + across[2] * across[2])
    for i in range(3):
        across[i] /= size
    across[3] = direction[1] * across[2] - direction[2] * across[1]
    across[4] = direction[2] * across[0] - direction[0] * across[2]
    across[5] = direction[0] * across[1] - direction[1] * across[0]


@called
def capped(vector: Pointer, at: int, size: int, longest: float) -> float:
    """The factor by which a vector is shortened to be no longer than `longest`."""
    total = 0.0
    for i in range(size):
        total += vector[at + i] * vector[at + i]
    length = float(math.sqrt(total))
    return longest / length if length > longest else 1.0


@called
def relative_to(program: Pointer, desk: Pointer, task: Pointer, pose: Pointer, J: Pointer) -> None:
    """Replaces the pose and J of a frame by those relative to the task's root, in its axes."""
    n = int(program[slots.JOINTS])
    root = frame_place(program, desk, int(task[slots.ROOT]))
    other = further(root, END)
    for i in range(6 * n):
        J[i] -= other[i]
    a, b, c = pose[9] - root[9], pose[10] - root[10], pose[11] - root[11]
    for i in range(n):
        x, y, z = other[3 * n + i], other[4 * n + i], other[5 * n + i]
        J[i] += b * z - c * y
        J[n + i] += c * x - a * z
        J[2 * n + i] += a * y - b * x
    pose[9], pose[10], pose[11] = a, b, c
    turn_pose(root, pose)
    turn_rows(root, J, n)


@called
def error_of(task: Pointer, pose: Pointer, goal: Pointer, error: Pointer) -> None:
    """Fills in the pose error in the task's rows, zero in the others."""
    kind = int(task[slots.ROTATION])
    for i in range(3):
        error[i], error[3 + i] = goal[9 + i] - pose[9 + i], 0.0
    if kind != slots.NO_ROTATION:
        way = stack(0.0, ONE, NINE)
        for r in range(3):
            for c in range(3):
                way[3 * r + c] = (
                    goal[3 * r] * pose[3 * c] + goal[3 * r + 1] * pose[3 * c + 1] + goal[3 * r + 2] * pose[3 * c + 2]
                )
        if kind == slots.WHOLE_ROTATION:
            rotation_vector(way, further(error, 3))
        else:
            free, axis = kind - slots.SWING, stack(0.0, ONE, THREE)
            for i in range(3):
                axis[i] = 1.0 if i == free else 0.0
            swing(further(way, 3 * free), axis, further(error, 3))
    for i in range(6):
        chosen = False
        for r in range(int(task[slots.HEIGHT])):
            chosen |= int(task[slots.CHOSEN + r]) == i
        if not chosen:
            error[i] = 0.0


@called
def pose_rows(program: Pointer, desk: Pointer, task: Pointer, J: Pointer, x: Pointer, error: Pointer) -> int:
    """Fills in the rows of a task that brings a frame to a pose; a status."""
    n, place = int(program[slots.JOINTS]), frame_place(program, desk, int(task[slots.PLACE]))
    pose, twists = stack(0.0, ONE, TWELVE), stack(0.0, ONE, ROWS)
    goal, off, forward = stack(0.0, ONE, TWELVE), stack(0.0, ONE, SIX), stack(0.0, ONE, SIX)
    status = read_goal(task, goal)
    if status != slots.DONE:
        return status
    for i in range(END):
        pose[i] = place[i]
    for i in range(6 * n):
        twists[i] = place[END + i]
    for i in range(6):
        forward[i] = task[slots.FORWARD + i]
    if task[slots.ROOT] >= 0.0:
        relative_to(program, desk, task, pose, twists)
    if task[slots.AXES] == slots.TARGET_AXES:
        axes = stack(0.0, ONE, NINE)
        for i in range(9):
            axes[i] = goal[i]
        turn_pose(axes, pose)
        turn_pose(axes, goal)
        turn_rows(axes, twists, n)
        turn(axes, True, forward, 0, 1)
        turn(axes, True, forward, 3, 1)
    error_of(task, pose, goal, off)
    shorter = (capped(off, 0, 3, task[slots.LINEAR]), capped(off, 3, 3, task[slots.ANGULAR]))
    for r in range(int(task[slots.HEIGHT])):
        row = int(task[slots.CHOSEN + r])
        factor = row_factor(program, task, row)
        error[r] = off[row] * factor
        x[r] = (forward[row] + task[slots.GAIN_OF] * (shorter[0 if row < 3 else 1] * off[row])) * factor
        choose(program, twists, row, factor, J, r)
    return slots.DONE


@called
def row_factor(program: Pointer, task: Pointer, row: int) -> float:
    """The weight of a task, in the unit of one of the six rows."""
    unit = program[slots.LENGTH] if row < 3 else 1.0
    return float(task[slots.WEIGHT] / unit)


@called
def choose(program: Pointer, twists: Pointer, row: int, factor: float, J: Pointer, to: int) -> None:
    """Copies a row of twists to a row of J, times a factor and the units of the joints."""
    n, joints = int(program[slots.JOINTS]), int(program[slots.MAP])
    for c in range(n):
        J[to * n + c] = twists[row * n + c] * factor * program[joints + c * slots.MAPPED + slots.UNIT]


@called
def twist_rows(program: Pointer, desk: Pointer, task: Pointer, J: Pointer, x: Pointer, error: Pointer) -> int:
    """Fills in the rows of a task that moves a frame with a twist; a status."""
    n, place = int(program[slots.JOINTS]), frame_place(program, desk, int(task[slots.PLACE]))
    twists, good = stack(0.0, ONE, ROWS), True
    for i in range(6 * n):
        twists[i] = place[END + i]
    for i in range(6):
        good &= is_measured(task[slots.FORWARD + i])
    if not good:
        return slots.NOT_FINITE
    if task[slots.AXES] == slots.FRAME_AXES:
        turn_rows(place, twists, n)
    for r in range(int(task[slots.HEIGHT])):
        row = int(task[slots.CHOSEN + r])
        factor = row_factor(program, task, row)
        x[r], error[r] = task[slots.FORWARD + row] * factor, 0.0
        choose(program, twists, row, factor, J, r)
    return slots.DONE


@called
def is_unit(vector: Pointer) -> bool:
    """Whether three numbers are a vector of length 1."""
    return bool(abs(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2] - 1.0) <= 2.0 * RIGID)


@called
def direction_rows(program: Pointer, desk: Pointer, task: Pointer, J: Pointer, x: Pointer, error: Pointer) -> int:
    """Fills in the rows of a task that points an axis of a frame along a direction; a status."""
    n, pose = int(program[slots.JOINTS]), frame_place(program, desk, int(task[slots.PLACE]))
    now, off, across = stack(0.0, ONE, THREE), stack(0.0, ONE, THREE), stack(0.0, ONE, SIX)
    axis, towards, twists = further(task, slots.AXIS), further(task, slots.TOWARDS), further(pose, END)
    units, total = int(program[slots.MAP]), 0.0
    for i in range(3):
        now[i] = pose[3 * i] * axis[0] + pose[3 * i + 1] * axis[1] + pose[3 * i + 2] * axis[2]
        total += now[i] + towards[i]
    if not math.isfinite(total):
        return slots.NOT_FINITE
    if not (is_unit(axis) and is_unit(towards)):
        return slots.NOT_RIGID
    perpendicular(towards, across)
    swing(now, towards, off)
    errors = stack(0.0, ONE, THREE)
    for r in range(2):
        errors[r] = across[3 * r] * off[0] + across[3 * r + 1] * off[1] + across[3 * r + 2] * off[2]
    shorter, weight = capped(errors, 0, 2, task[slots.ANGULAR]), task[slots.WEIGHT]
    for r in range(2):
        error[r], x[r] = errors[r] * weight, task[slots.GAIN_OF] * (shorter * errors[r]) * weight
        for c in range(n):
            total = 0.0
            for i in range(3):
                total += across[3 * r + i] * twists[(3 + i) * n + c]
            J[r * n + c] = total * weight * program[units + c * slots.MAPPED + slots.UNIT]
    return slots.DONE
