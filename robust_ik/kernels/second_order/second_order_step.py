"""A step of the second-order inverse, from an equation J q̇ = ẋ and ∂J/∂q, with the memory of a run."""

from __future__ import annotations

import math

from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, Pointer, Sizes, further, stack
from robust_ik.kernels.matrices.small_svd import SMALLEST
from robust_ik.kernels.second_order import second_order_layout as lay
from robust_ik.kernels.second_order.quartic import make_quartic
from robust_ik.kernels.second_order.turning import add_turn, note, unserved
from robust_ik.kernels.second_order.weak_motion import joint_motion, weak_motion
from robust_ik.kernels.second_order.weak_rows import bend_rows, largest_of, split_rows, vector_of


@called
def first_order(
    parameters: Pointer, memory: Pointer, J: Pointer, x: Pointer, m: int, n: int, least: float, sheet: Pointer,
    out: Pointer, width: Sizes,
) -> bool:  # fmt: skip
    """Fills in the motion of the kept rows; whether weak rows are to be served by `second_order`. If not, all is done.

    Args:
        parameters: See `second_order_layout`.
        memory: Of the run; moved on if the step is made.
        J: (m, n).
        x: ẋ, (m,).
        m: Number of rows.
        n: Number of joints.
        least: See `split_rows`.
        sheet: Filled.
        out: (n,), filled.
        width: At least m and n.
    """
    needed = False
    sheet[lay.WEAK], sheet[lay.FREE], sheet[lay.KEPT] = 0.0, float(n), 0.0
    for c in range(n):
        out[c] = 0.0
    if max(largest_of(J, m * n), least) >= SMALLEST:
        needed = split_rows(parameters, J, x, m, n, least, sheet, width)
        for c in range(n):
            out[c] = vector_of(sheet, lay.KEPT_MOTION, width)[c]
        if not needed:
            note(memory, x, m, n, 0.0, 0.0, parameters[lay.DT])
    if not needed:
        remember(memory, out, n)
    return needed and not math.isnan(finite_sum(out, n))


@called
def second_order(
    parameters: Pointer, memory: Pointer, forms: Pointer, x: Pointer, m: int, n: int, sheet: Pointer, out: Pointer,
    width: Sizes,
) -> None:  # fmt: skip
    """Adds the motion of the weak rows to that of the kept ones.

    Args:
        parameters: See `second_order_layout`.
        memory: Of the run; moved on.
        forms: uᵀ ∂J/∂q of each weak row u, (k, n, n), of which the symmetric part counts; not left as they were.
        x: ẋ, (m,).
        m: Number of rows.
        n: Number of joints.
        sheet: From `first_order`.
        out: (n,), from `first_order`.
        width: At least m and n.
    """
    z, motion, last = stack(0.0, ONE, width), stack(0.0, ONE, width), further(memory, lay.LAST)
    bend_rows(forms, n, sheet, width)
    make_quartic(parameters, sheet, width)
    weak_motion(sheet, last, n, parameters[lay.SPEED], z, width)
    note(memory, x, m, n, unserved(sheet, z, width), sheet[lay.CURVATURE], parameters[lay.DT])
    add_turn(memory, sheet, n, parameters, z, width)
    joint_motion(sheet, z, n, motion, width)
    for c in range(n):
        out[c] += motion[c]
    remember(memory, out, n)


@called
def remember(memory: Pointer, out: Pointer, n: int) -> None:
    """Keeps the velocities as the last ones, if they are numbers."""
    if not math.isnan(finite_sum(out, n)):
        for c in range(n):
            memory[lay.LAST + c] = out[c]


@called
def finite_sum(vector: Pointer, size: int) -> float:
    """0 if all is finite, else NaN."""
    total = 0.0
    for i in range(size):
        total += vector[i] * 0.0
    return total
