"""Gradients of what Jacobians of frames make of a wrench and a joint motion, and of the measure of levels together.

The compiled form of `kinematics.singular_value_gradients` for the rows of tasks.
"""

from __future__ import annotations

from robust_ik.kernels.chain import chain_layout as links
from robust_ik.kernels.chain.chain_kinematics import MOST_JOINTS, SIX
from robust_ik.kernels.chain.hessian_contraction import bend
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.frame_motion import END, frame_place, map_of
from robust_ik.kernels.control.level_freedom import MATRIX, VECTOR, record_of
from robust_ik.kernels.control.pose_rows import NINE, THREE, perpendicular, row_factor, turn
from robust_ik.kernels.matrices.small_svd import decompose_some


@called
def add_gradient(
    program: Pointer, desk: Pointer, frame: int, wrench: Pointer, v: Pointer, share: float, gradient: Pointer
) -> None:
    """Adds share · wrenchᵀ (∂J/∂q) v of a frame's Jacobian along the world's axes."""
    n, place = int(program[slots.JOINTS]), frame_place(program, desk, frame)
    chain = further(program, int(program[int(program[slots.FRAME]) + 2 * frame]))
    twists, count = further(place, END + 6 * n), int(chain[links.JOINTS])
    motions, bends = stack(0.0, ONE, MOST_JOINTS), stack(0.0, MOST_JOINTS, SIX)
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
def add_turning(
    program: Pointer, desk: Pointer, frame: int, wrench: Pointer, v: Pointer, share: float, gradient: Pointer
) -> None:
    """Adds what rows along the frame's own axes have besides: −share · wrench · (ω_k × J v), linear and angular."""
    n, place = int(program[slots.JOINTS]), frame_place(program, desk, frame)
    J, moving = further(place, END), stack(0.0, ONE, SIX)
    for r in range(6):
        moving[r] = 0.0
        for c in range(n):
            moving[r] += J[r * n + c] * v[c]
    for c in range(n):
        x, y, z = J[3 * n + c], J[4 * n + c], J[5 * n + c]
        for r in range(0, 6, 3):
            a, b, d = moving[r], moving[r + 1], moving[r + 2]
            turned = wrench[r] * (y * d - z * b) + wrench[r + 1] * (z * a - x * d) + wrench[r + 2] * (x * b - y * a)
            gradient[c] -= share * turned


@called
def wrench_of(program: Pointer, desk: Pointer, task: Pointer, u: Pointer, step: int, wrench: Pointer) -> None:
    """Fills in the wrench, along the world's axes, of weights u of a task's rows; u has one every `step` places."""
    for r in range(6):
        wrench[r] = 0.0
    if task[slots.KIND] == slots.DIRECTION:
        across, towards = stack(0.0, ONE, SIX), stack(0.0, ONE, THREE)
        for i in range(3):
            towards[i] = task[slots.TOWARDS + i]
        perpendicular(towards, across)
        for r in range(2):
            for i in range(3):
                wrench[3 + i] += u[r * step] * task[slots.WEIGHT] * across[3 * r + i]
        return
    for r in range(int(task[slots.HEIGHT])):
        row = int(task[slots.CHOSEN + r])
        wrench[row] = u[r * step] * row_factor(program, task, row)
    if task[slots.AXES] != slots.WORLD_AXES:
        axes, pose = stack(0.0, ONE, NINE), frame_place(program, desk, int(task[slots.PLACE]))
        for r in range(3):
            for c in range(3):
                target = task[slots.GOAL + 4 * r + c]
                axes[3 * r + c] = target if task[slots.AXES] == slots.TARGET_AXES else pose[3 * r + c]
        turn(axes, False, wrench, 0, 1)
        turn(axes, False, wrench, 3, 1)


@called
def measure_gradient(program: Pointer, desk: Pointer, levels: int, gradient: Pointer, width: Sizes) -> float:
    """Fills in the gradient of the product of the singular values of the first levels' rows together; returns it.

    Args:
        program: See `control_layout`; tasks lead frames or joints.
        desk: The same, with the levels' Jacobians.
        levels: How many levels; 0 for a product of 1.
        gradient: (n,), filled.
        width: At least the number of joints, and of rows of the levels together.
    """
    n, rows = int(program[slots.JOINTS]), 0
    A, U, s, Vt = stack(0.0, ONE, MATRIX), stack(0.0, ONE, MATRIX), stack(0.0, ONE, VECTOR), stack(0.0, ONE, MATRIX)
    for c in range(n):
        gradient[c] = 0.0
    for level in range(levels):
        record = record_of(program, level)
        J = further(desk, int(record[slots.JACOBIAN]))
        for i in range(int(record[slots.M]) * n):
            A[rows * n + i] = J[i]
        rows += int(record[slots.M])
    k, product = min(rows, n), 1.0
    if levels == 0:
        return product
    decompose_some(A, U, s, Vt, rows, n, k, 1, width, width, 0.0)
    for i in range(k):
        product *= s[i]
        others = 1.0
        for j in range(k):
            others *= s[j] if j != i else 1.0
        if others > 0.0:
            add_direction(program, desk, levels, further(U, i), k, further(Vt, i * n), others, gradient)
    for c in range(n):
        gradient[c] *= map_of(program, c)[slots.UNIT]
    return product


@called
def add_direction(
    program: Pointer, desk: Pointer, levels: int, u: Pointer, step: int, v: Pointer, share: float, gradient: Pointer
) -> None:
    """Adds share · uᵀ (∂J/∂q) v of the rows of the first levels together."""
    n, row = int(program[slots.JOINTS]), 0
    moved, wrench = stack(0.0, ONE, VECTOR), stack(0.0, ONE, SIX)
    for c in range(n):
        moved[c] = v[c] * map_of(program, c)[slots.UNIT]
    for level in range(levels):
        record = record_of(program, level)
        task = further(program, int(record[slots.TASK]))
        for _ in range(int(record[slots.TASKS])):
            if task[slots.KIND] != slots.JOINT_VALUES:
                frame = int(task[slots.PLACE])
                wrench_of(program, desk, task, further(u, row * step), step, wrench)
                add_gradient(program, desk, frame, wrench, moved, share, gradient)
                if task[slots.KIND] == slots.TWIST and task[slots.AXES] == slots.FRAME_AXES:
                    add_turning(program, desk, frame, wrench, moved, share, gradient)
            row += int(task[slots.HEIGHT])
            task = further(task, int(task[slots.LONG]))
