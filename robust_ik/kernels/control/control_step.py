"""A controller's whole step: rows of tasks, bounds, the walk down the levels, and the velocities."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import Pointer, Sizes, further
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.calming import calm
from robust_ik.kernels.control.level_freedom import record_of
from robust_ik.kernels.control.resolve_levels import resolve
from robust_ik.kernels.control.rows.climbing_rows import climbing_rows
from robust_ik.kernels.control.rows.frame_motion import check_configuration, map_of, move_frames
from robust_ik.kernels.control.rows.joint_rows import joint_bounds, joint_rows
from robust_ik.kernels.control.rows.pose_rows import direction_rows, pose_rows, twist_rows
from robust_ik.kernels.control.weighted_levels import weigh_levels


@called
def task_rows(
    program: Pointer, desk: Pointer, q: Pointer, task: Pointer, J: Pointer, x: Pointer, error: Pointer, width: Sizes
) -> int:
    """Fills in the rows of one task; a status."""
    kind = task[slots.KIND]
    if kind == slots.POSE:
        return pose_rows(program, desk, task, J, x, error)
    if kind == slots.JOINT_VALUES:
        return joint_rows(program, q, task, J, x, error)
    if kind == slots.TWIST:
        return twist_rows(program, desk, task, J, x, error)
    if kind == slots.DIRECTION:
        return direction_rows(program, desk, task, J, x, error)
    if kind == slots.CLIMB:
        return climbing_rows(program, desk, task, J, x, error, width)
    return slots.DONE


@called
def equations(program: Pointer, desk: Pointer, q: Pointer, width: Sizes) -> int:
    """Fills in J, ẋ and the error of every level; a status."""
    n = int(program[slots.JOINTS])
    move_frames(program, desk, q)
    for level in range(int(program[slots.LEVELS])):
        record, row = record_of(program, level), 0
        task = further(program, int(record[slots.TASK]))
        J, x = further(desk, int(record[slots.JACOBIAN])), further(desk, int(record[slots.X]))
        error = further(desk, int(record[slots.ERROR]))
        for _ in range(int(record[slots.TASKS])):
            status = task_rows(program, desk, q, task, further(J, row * n), further(x, row), further(error, row), width)
            if status != slots.DONE:
                return status
            row += int(task[slots.HEIGHT])
            task = further(task, int(task[slots.LONG]))
    return slots.DONE


@called
def finish(program: Pointer, desk: Pointer, out: Pointer) -> int:
    """Writes the velocities in metres and radians, and takes note of them; TOO_LARGE if infinite."""
    qdot, last = further(desk, int(program[slots.QDOT])), further(desk, int(program[slots.LAST]))
    total = 0.0
    for i in range(int(program[slots.JOINTS])):
        total += qdot[i] * 0.0
    if math.isnan(total):
        return slots.TOO_LARGE
    for i in range(int(program[slots.JOINTS])):
        out[i] = qdot[i] * map_of(program, i)[slots.UNIT]
        last[i] = qdot[i]
    calm(program, desk)
    program[slots.MADE] += 1.0
    return slots.DONE


@called
def remember(program: Pointer, desk: Pointer, q: Pointer) -> None:
    """Keeps q and the last velocities for the report of the step, and what has been noted, to take it back."""
    asked, before = further(desk, int(program[slots.ASKED])), further(desk, int(program[slots.BEFORE]))
    noted, earlier = further(desk, int(program[slots.CALM])), further(desk, int(program[slots.EARLIER]))
    last = further(desk, int(program[slots.LAST]))
    for i in range(int(program[slots.CONFIGURATION])):
        asked[i] = q[i]
    for i in range(int(program[slots.JOINTS])):
        before[i] = last[i]
    for i in range(int(program[slots.NOTED])):
        earlier[i] = noted[i]


@called
def take_back(program: Pointer, desk: Pointer) -> None:
    """Remembers what was remembered before the step: NumPy makes it, or nobody does."""
    noted, earlier = further(desk, int(program[slots.CALM])), further(desk, int(program[slots.EARLIER]))
    for i in range(int(program[slots.NOTED])):
        noted[i] = earlier[i]


WANTED = slots.ENTRIES + 1
"""The first number of a task's record that says what it wants; those before are gains, weights, caps."""


@called
def look_at_tasks(program: Pointer, desk: Pointer) -> None:
    """Notes for how long the tasks have wanted the same; of rows from outside nobody knows, so they count as moving."""
    if program[slots.TURNING] == 0.0:
        return
    memory, total, count, moves = further(desk, int(program[slots.CALM])), 0.0, 1.0, False
    for level in range(int(program[slots.LEVELS])):
        record = record_of(program, level)
        task = further(program, int(record[slots.TASK]))
        for _ in range(int(record[slots.TASKS])):
            moves |= task[slots.KIND] == slots.GIVEN
            for i in range(WANTED, int(task[slots.LONG])):
                total += count * task[i]
                count += 1.0
            task = further(task, int(task[slots.LONG]))
    if total != memory[slots.CALM_TASKS] and memory[slots.CALM_TASKS] != 0.0:
        memory[slots.CALM_STILL], memory[slots.CALM_FREE] = 0.0, 1.0
    else:
        memory[slots.CALM_STILL] = 0.0 if moves else memory[slots.CALM_STILL] + program[slots.DT]
    memory[slots.CALM_TASKS] = total


@called
def pose_problem(program: Pointer, desk: Pointer, q: Pointer, width: Sizes) -> int:
    """Puts on the desk what a step from q has to solve: the levels' equations, and the bounds; a status."""
    remember(program, desk, q)
    status = check_configuration(program, q)
    if status != slots.DONE:
        return status
    look_at_tasks(program, desk)
    status = equations(program, desk, q, width)
    if status == slots.DONE and program[slots.LIMITS] > 0.0:
        joint_bounds(program, desk, q)
    return status


@called
def control_step(program: Pointer, desk: Pointer, q: Pointer, out: Pointer, width: Sizes) -> int:
    """One step from q; a status. `out`, the last velocities and what is noted change only if it is DONE."""
    status = pose_problem(program, desk, q, width)
    first = int(0.0)  # for a literal 0 Numba would compile `resolve` once more
    if status == slots.DONE and program[slots.RESOLVER] == slots.WEIGHTED:
        status = weigh_levels(program, desk, width)
    elif status == slots.DONE:
        status = resolve(program, desk, first, first > 0, width)
    if status == slots.DONE:
        status = finish(program, desk, out)
    if slots.DONE < status < slots.WANTS_MOTION:
        take_back(program, desk)
    return status
