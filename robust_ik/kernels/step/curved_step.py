"""A control step by the second-order inverse, as the first step of a run: J, curvature where it is needed, q̇."""

from __future__ import annotations

from typing import Any

from robust_ik.kernels.chain.chain_kinematics import MOST_JOINTS, SIX, TWELVE, place
from robust_ik.kernels.chain.chain_layout import INDEPENDENT
from robust_ik.kernels.chain.joint_motion import joint_twists
from robust_ik.kernels.chain.wrench_form import add_wrench_form
from robust_ik.kernels.compiler.array_handles import address_of, int64_at, numbers_of
from robust_ik.kernels.compiler.compiling import HANDLE, WHOLE, called, inlined, kernel
from robust_ik.kernels.compiler.stack_memory import ONE, W8, W16, Pointer, Sizes, further, stack
from robust_ik.kernels.loader.array_layout import WRITEABLE
from robust_ik.kernels.matrices.small_products import dot
from robust_ik.kernels.second_order import second_order_layout as lay
from robust_ik.kernels.second_order.second_order_entries import SHEET_8, SHEET_16, SQUARE_8, SQUARE_16
from robust_ik.kernels.second_order.second_order_step import first_order, second_order
from robust_ik.kernels.second_order.weak_rows import left_of, matrix_of
from robust_ik.kernels.step import step_layout as slots
from robust_ik.kernels.step.step import store
from robust_ik.kernels.step.step_entries import PLAIN, fit, fits, program_of
from robust_ik.kernels.step.step_layout import DONE, UNLIKE
from robust_ik.kernels.step.step_task import check, scale_columns, scale_rows, task

STEP = WHOLE, HANDLE, HANDLE, HANDLE, HANDLE


@called
def task_forms(program: Pointer, q: Pointer, sheet: Pointer, forms: Pointer, width: Sizes) -> None:
    """Fills in uᵀ ∂J/∂q of each weak row u, (k, n, n), in the task rows and scaled by the weights as J is."""
    chain, m, reference = further(program, int(program[slots.CHAIN])), int(program[slots.ROWS]), slots.REFERENCE
    n, at, joints = int(chain[INDEPENDENT]), int(program[slots.TASK]), int(program[slots.JOINTS])
    axes, end, wrench = stack(0.0, MOST_JOINTS, SIX), stack(0.0, ONE, TWELVE), stack(0.0, ONE, SIX)
    place(chain, q, 1, axes, end, 0.0)
    joint_twists(chain, axes, end, axes, int(program[reference]), 0.0)
    for i in range(int(sheet[lay.WEAK])):
        form = further(forms, i * n * n)
        for x in range(n * n):
            form[x] = 0.0
        for r in range(6):
            wrench[r] = 0.0
        for r in range(m):
            if at > 0:
                for c in range(m):
                    wrench[int(program[slots.ROW + c])] += left_of(sheet, r, i, width) * program[at + r * m + c]
            else:
                wrench[int(program[slots.ROW + r])] += left_of(sheet, r, i, width)
        add_wrench_form(chain, axes, wrench, int(program[reference]), form)
        if joints > 0:
            scale_columns(further(program, joints), n, form, n, n, 0.0)
            scale_rows(further(program, joints), n, form, n, 0.0)


@called
def curved_step(
    program: Pointer, q: Pointer, twist: Pointer, beside: Pointer, wanted: bool, out: Pointer, sheet: Sizes,
    width: Sizes, square: Sizes,
) -> int:  # fmt: skip
    """One step, with a secondary joint velocity `beside` in the null space if `wanted`."""
    P, m = len(width), int(program[slots.ROWS])
    n = int(program[int(program[slots.CHAIN]) + INDEPENDENT])
    J, x, found, rows = stack(0.0, W8, width), stack(0.0, ONE, W8), stack(0.0, ONE, width), stack(0.0, sheet, width)
    memory, parameters = stack(0.0, W8, width), further(program, int(program[slots.PARAMETERS]))
    status = check(program, q, twist)
    if status != DONE:
        return status
    task(program, q, twist, 1, J, x, width, 0.0)
    for r in range(m):
        for c in range(n):
            J[r * n + c] = J[r * P + c]
    for c in range(lay.LAST + n):
        memory[c] = 0.0
    if first_order(parameters, memory, J, x, m, n, 0.0, rows, found, width):
        forms = stack(0.0, square, width)
        task_forms(program, q, rows, forms, width)
        second_order(parameters, memory, forms, x, m, n, rows, found, width)
    factors = further(program, int(program[slots.JOINTS]))
    if wanted:
        add_free(program, rows, n, beside, found, width)
    if program[slots.JOINTS] > 0.0:
        scale_rows(factors, n, found, 1, 0.0)
    return store(found, out, n, 0, 1)


@called
def add_free(program: Pointer, sheet: Pointer, n: int, beside: Pointer, out: Pointer, width: Sizes) -> None:
    """Adds the part of a secondary joint velocity that is orthogonal to all singular directions."""
    rest = stack(0.0, ONE, width)
    for c in range(n):
        rest[c] = beside[c]
    if program[slots.JOINTS] > 0.0:
        scale_rows(further(program, int(program[slots.JOINTS]) + n * n), n, rest, 1, 0.0)
    for i in range(int(sheet[lay.KEPT] + sheet[lay.WEAK])):
        v = further(matrix_of(sheet, lay.RIGHT, width), i * n)
        share = dot(v, rest, n)
        for c in range(n):
            rest[c] -= share * v[c]
    for c in range(n):
        out[c] += rest[c]


@inlined
def curved(setup: int, q: Any, twist: Any, beside: Any, out: Any, sheet: Sizes, width: Sizes, square: Sizes) -> int:
    """A step, with a secondary joint velocity unless it is None, if the vectors have the right lengths, else UNLIKE."""
    wanted = address_of(beside) != int64_at(setup + 16)
    if not (fit(setup, q, twist) and fits(setup, out, PLAIN | WRITEABLE)):
        return UNLIKE
    if wanted and not fits(setup, beside, PLAIN):
        return UNLIKE
    start = numbers_of(beside) if wanted else numbers_of(q)
    return curved_step(
        program_of(setup), numbers_of(q), numbers_of(twist), start, wanted, numbers_of(out), sheet, width, square
    )


@kernel(*STEP)
def curved_8(setup: int, q: Any, twist: Any, beside: Any, out: Any) -> int:
    """A second-order step of a robot of at most 8 joints, with a secondary velocity unless it is None; its status."""
    return curved(setup, q, twist, beside, out, SHEET_8, W8, SQUARE_8)


@kernel(*STEP)
def curved_16(setup: int, q: Any, twist: Any, beside: Any, out: Any) -> int:
    """A second-order step of a robot of at most 16 joints, with a secondary velocity unless it is None; its status."""
    return curved(setup, q, twist, beside, out, SHEET_16, W16, SQUARE_16)
