"""How the Jacobians of rows change with the joints: ∂J/∂q by weights of rows, and by joint motions.

The compiled form of `kinematics.singular_value_gradients` for the rows of tasks, with the gradient of the measure of
levels together; and of the Hessians of tasks of frames, as quadratic forms of which the symmetric part counts.
"""

from __future__ import annotations

from robust_ik.kernels.chain import chain_layout as links
from robust_ik.kernels.chain.chain_kinematics import MOST_JOINTS, SIX
from robust_ik.kernels.chain.hessian_contraction import bend
from robust_ik.kernels.chain.wrench_form import add_aligned_form
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, stack
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.level_freedom import MATRIX, VECTOR, record_of
from robust_ik.kernels.control.rows.frame_motion import END, frame_place, map_of
from robust_ik.kernels.control.rows.pose_rows import NINE, THREE, perpendicular, row_factor, turn
from robust_ik.kernels.matrices.small_products import dot, multiply, multiply_transposed
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


@called
def add_curvature(program: Pointer, desk: Pointer, level: int, u: Pointer, form: Pointer) -> None:
    """Fills in uᵀ ∂J/∂q of a level's rows, (n, n), in the units of the joints.

    Args:
        program: See `control_layout`; ∂J/∂q of all rows is known.
        desk: The same, with the frames, and ∂J/∂q of rows from outside.
        level: The level.
        u: Weights of its rows, (m,).
        form: Filled.
    """
    record, n, row = record_of(program, level), int(program[slots.JOINTS]), 0
    for i in range(n * n):
        form[i] = 0.0
    task = further(program, int(record[slots.TASK]))
    for _ in range(int(record[slots.TASKS])):
        weights = further(u, row)
        if task[slots.KIND] == slots.GIVEN:
            H = further(desk, int(record[slots.CURVATURE]) + row * n * n)
            for r in range(int(task[slots.HEIGHT])):
                for i in range(n * n):
                    form[i] += weights[r] * H[r * n * n + i]
        elif task[slots.KIND] != slots.JOINT_VALUES:
            add_frame_form(program, desk, task, weights, form)
        row += int(task[slots.HEIGHT])
        task = further(task, int(task[slots.LONG]))
    for j in range(n):
        for k in range(n):
            form[j * n + k] *= map_of(program, j)[slots.UNIT] * map_of(program, k)[slots.UNIT]


@called
def add_frame_form(program: Pointer, desk: Pointer, task: Pointer, u: Pointer, form: Pointer) -> None:
    """Adds what a task of a frame has of it, for weights u of its rows."""
    frame, wrench = int(task[slots.PLACE]), stack(0.0, ONE, SIX)
    wrench_of(program, desk, task, u, 1, wrench)
    if task[slots.KIND] == slots.POSE and task[slots.ROOT] >= 0.0:
        add_relative_form(program, desk, frame, int(task[slots.ROOT]), wrench, form)
        return
    add_form(program, desk, frame, wrench, form)
    if task[slots.KIND] == slots.TWIST and task[slots.AXES] == slots.FRAME_AXES:
        J = further(frame_place(program, desk, frame), END)
        add_turning_form(J, J, wrench, int(program[slots.JOINTS]), form)


@called
def add_form(program: Pointer, desk: Pointer, frame: int, wrench: Pointer, form: Pointer) -> None:
    """Adds a wrench by ∂J/∂q of a frame, along the world's axes."""
    chain = further(program, int(program[int(program[slots.FRAME]) + 2 * frame]))
    twists = further(frame_place(program, desk, frame), END + 6 * int(program[slots.JOINTS]))
    if int(chain[links.JOINTS]) > 0:
        add_aligned_form(chain, twists, wrench, form)


@called
def add_turning_form(axes: Pointer, J: Pointer, wrench: Pointer, n: int, form: Pointer) -> None:
    """Adds what rows along axes that turn have besides: −f · (ω_k × v_j) − t · (ω_k × w_j).

    Args:
        axes: The Jacobian of the frame that turns the axes, (6, n).
        J: The Jacobian of which rows are taken, (6, n), along the world's axes: columns (v, w).
        wrench: (f, t), along the world's axes.
        n: Number of joints.
        form: Added to.
    """
    for k in range(n):
        x, y, z = axes[3 * n + k], axes[4 * n + k], axes[5 * n + k]
        for r in range(0, 6, 3):
            f, g, h = wrench[r], wrench[r + 1], wrench[r + 2]
            a, b, c = g * z - h * y, h * x - f * z, f * y - g * x  # f · (ω × v) = (f × ω) · v
            for j in range(n):
                form[j * n + k] -= a * J[r * n + j] + b * J[(r + 1) * n + j] + c * J[(r + 2) * n + j]


@called
def add_relative_form(program: Pointer, desk: Pointer, frame: int, root: int, wrench: Pointer, form: Pointer) -> None:
    """Adds what a frame's motion relative to another has; see `tasks.relative.relative_motion`.

    Args:
        program: See `control_layout`.
        desk: The same, with the frames.
        frame: The frame.
        root: The other.
        wrench: Along the axes of the other; turned to those of the world.
        form: Added to.
    """
    n, one, other = int(program[slots.JOINTS]), frame_place(program, desk, frame), frame_place(program, desk, root)
    J, K, moved, back = further(one, END), further(other, END), stack(0.0, ONE, MATRIX), stack(0.0, ONE, SIX)
    turn(other, False, wrench, 0, 1)
    turn(other, False, wrench, 3, 1)
    x, y, z = one[9] - other[9], one[10] - other[10], one[11] - other[11]
    f, g, h = wrench[0], wrench[1], wrench[2]
    back[0], back[1], back[2] = -f, -g, -h
    back[3] = g * z - h * y - wrench[3]
    back[4] = h * x - f * z - wrench[4]
    back[5] = f * y - g * x - wrench[5]
    add_form(program, desk, frame, wrench, form)
    add_form(program, desk, root, back, form)
    for i in range(6 * n):
        moved[i] = J[i] - K[i]
    for k in range(n):  # f · (∂r/∂q_k × ω_j) = (f × ∂r/∂q_k) · ω_j
        u, v, w = moved[k], moved[n + k], moved[2 * n + k]
        a, b, c = g * w - h * v, h * u - f * w, f * v - g * u
        for j in range(n):
            form[j * n + k] += a * K[3 * n + j] + b * K[4 * n + j] + c * K[5 * n + j]
    for j in range(n):  # the offset turns with the other frame: r × ω_j
        u, v, w = K[3 * n + j], K[4 * n + j], K[5 * n + j]
        moved[j] += y * w - z * v
        moved[n + j] += z * u - x * w
        moved[2 * n + j] += x * v - y * u
    add_turning_form(K, moved, wrench, n, form)


@called
def projected(form: Pointer, basis: Pointer, n: int, d: int) -> None:
    """Replaces a form, (n, n), by N form N, where N projects onto the span of d orthonormal rows of length n."""
    half, small = stack(0.0, ONE, MATRIX), stack(0.0, ONE, MATRIX)
    multiply(basis, d, n, form, n, half)
    for i in range(d):
        for e in range(d):
            small[i * d + e] = dot(further(half, i * n), further(basis, e * n), n)
    multiply(small, d, d, basis, n, half)
    multiply_transposed(basis, d, n, half, n, form)
