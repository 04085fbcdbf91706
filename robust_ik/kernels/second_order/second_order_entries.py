"""Entry points of the second-order inverse for Python."""

from __future__ import annotations

import math

from robust_ik.checks import Array
from robust_ik.kernels.compiler.compiling import filled, given, inlined, kernel
from robust_ik.kernels.compiler.stack_memory import W8, W16, Sizes, pointer, sizes, stack
from robust_ik.kernels.second_order.second_order_layout import sheet_size
from robust_ik.kernels.second_order.second_order_step import finite_sum, first_order, second_order
from robust_ik.kernels.second_order.weak_rows import forms_of

VELOCITY = given(2), given(1), given(3), given(1), filled(1), filled(1)
SHEET_8, SHEET_16 = sizes(-(-sheet_size(8) // 8)), sizes(-(-sheet_size(16) // 16))
SQUARE_8, SQUARE_16 = sizes(8 * 8), sizes(16 * 16)


@inlined
def velocity(
    J: Array, x: Array, H: Array, parameters: Array, memory: Array, out: Array, sheet: Sizes, square: Sizes,
    width: Sizes,
) -> bool:  # fmt: skip
    """A step; False if its velocities are no numbers: then `out` and the memory have no meaning."""
    m, n = J.shape
    rows, with_memory, wanted, to = stack(0.0, sheet, width), pointer(memory), pointer(x), pointer(out)
    if first_order(pointer(parameters), with_memory, pointer(J), wanted, m, n, 0.0, rows, to, width):
        forms = stack(0.0, square, width)
        forms_of(pointer(H), m, n, rows, forms, width)
        second_order(pointer(parameters), with_memory, forms, wanted, m, n, rows, to, width)
    return not math.isnan(finite_sum(to, n))


@kernel(*VELOCITY)
def velocity_8(J: Array, x: Array, H: Array, parameters: Array, memory: Array, out: Array) -> bool:
    """A step with at most 8 rows and joints, shapes unchecked; False if velocities are no numbers."""
    return velocity(J, x, H, parameters, memory, out, SHEET_8, SQUARE_8, W8)


@kernel(*VELOCITY)
def velocity_16(J: Array, x: Array, H: Array, parameters: Array, memory: Array, out: Array) -> bool:
    """A step with at most 16 rows and joints, shapes unchecked; False if velocities are no numbers."""
    return velocity(J, x, H, parameters, memory, out, SHEET_16, SQUARE_16, W16)
