"""Where the joints of a loop take a displacement or a point, how far that is from what is wanted, and the Jacobian.

Columns of the Jacobian are the axes carried along. Source: Murray, Li and Sastry 1994, section 3.4.
"""

from __future__ import annotations

import math

from robust_ik.checks import Array
from robust_ik.kernels.branches.branches_layout import MOTOR
from robust_ik.kernels.branches.motors import carried, conjugate, joint_motor, multiply
from robust_ik.kernels.chain.full_turns import unwound
from robust_ik.kernels.chain.sine_cosine import cosine_and_sine
from robust_ik.kernels.compiler.compiling import WHOLE, called, filled, given, inlined, kernel
from robust_ik.kernels.compiler.stack_memory import ONE, W8, Pointer, further, pointer, sizes, stack

SIX = sizes(6)


@inlined
def change(difference: float, slides: float) -> float:
    """A difference of joint values, turns modulo 2π."""
    return difference if slides > 0.0 else unwound(difference)


@called
def loop_state(
    axes: Pointer, slides: Pointer, k: int, q: Pointer, g: Pointer, p: Pointer, rows: int, J: Pointer, twist: Pointer
) -> float:  # fmt: skip
    """Fills in J, (rows, k), and the twist to g, (rows,); returns its largest entry.

    Args:
        axes: (k, 8).
        slides: Which slide, (k,).
        k: Number of joints, up to 16.
        q: Their values.
        g: What their motors shall multiply to.
        p: A point at zero and 1 for each of its coordinates that is wanted, (6,); read if rows is 3, where nothing else
            is wanted.
        rows: 6 or 3.
        J: Filled.
        twist: Filled.
    """
    reached, next_one, motor = stack(0.0, ONE, W8), stack(0.0, ONE, W8), stack(0.0, ONE, W8)
    at, wanted = stack(0.0, ONE, SIX), stack(0.0, ONE, SIX)
    reached[0] = 1.0
    for i in range(1, MOTOR):
        reached[i] = 0.0
    for j in range(k):
        axis = further(axes, MOTOR * j)
        carried(reached, axis, next_one)
        for i in range(3):
            if rows == 6:
                J[k * i + j], J[k * (3 + i) + j] = next_one[1 + i], next_one[5 + i]
            else:  # the moment for now, and the direction behind it
                J[k * i + j], J[k * (3 + i) + j] = next_one[5 + i], next_one[1 + i]
        if slides[j] > 0.0:
            joint_motor(axis, 1.0, 0.5 * q[j], motor)
        else:
            c, s = cosine_and_sine(0.5 * q[j])
            joint_motor(axis, c, s, motor)
        multiply(reached, motor, next_one)
        for i in range(MOTOR):
            reached[i] = next_one[i]
    largest = 0.0
    if rows == 6:
        conjugate(reached, next_one)
        multiply(g, next_one, motor)
        scale = 2.0 / math.copysign(max(abs(motor[0]), 0.1), motor[0])
        for i in range(3):
            twist[i], twist[3 + i] = scale * motor[1 + i], scale * motor[5 + i]
            largest = max(largest, abs(twist[i]), abs(twist[3 + i]))
        return largest
    place_point(reached, p, at)
    place_point(g, p, wanted)
    for i in range(3):
        twist[i] = p[3 + i] * (wanted[i] - at[i])
        largest = max(largest, abs(twist[i]))
    for j in range(k):
        a0, a1, a2 = J[3 * k + j], J[4 * k + j], J[5 * k + j]
        J[j] += a1 * at[2] - a2 * at[1]
        J[k + j] += a2 * at[0] - a0 * at[2]
        J[2 * k + j] += a0 * at[1] - a1 * at[0]
        for i in range(3):
            J[k * i + j] *= p[3 + i]
    return largest


@called
def place_point(M: Pointer, p: Pointer, to: Pointer) -> None:
    """Fills in where a displacement takes a point, (3,)."""
    ray, seen = stack(0.0, ONE, W8), stack(0.0, ONE, W8)
    for i in range(MOTOR):
        ray[i] = 0.0
    for i in range(3):
        ray[1 + i] = p[i]
    carried(M, ray, seen)  # R p
    w, x, y, z = M[0], M[1], M[2], M[3]
    to[0] = seen[1] + 2.0 * (w * M[5] - M[4] * x + (M[7] * y - M[6] * z))
    to[1] = seen[2] + 2.0 * (w * M[6] - M[4] * y + (M[5] * z - M[7] * x))
    to[2] = seen[3] + 2.0 * (w * M[7] - M[4] * z + (M[6] * x - M[5] * y))


@kernel(given(2), given(1), given(1), given(1), given(1), WHOLE, filled(2), filled(1))
def state_of_loop(
    axes: Array, slides: Array, values: Array, g: Array, p: Array, rows: int, J: Array, twist: Array
) -> float:  # fmt: skip
    """`loop_state` for arrays: J (6, k), whose first rows are filled, and the twist (6,). Shapes are unchecked."""
    return loop_state(
        pointer(axes), pointer(slides), axes.shape[0], pointer(values), pointer(g), pointer(p), rows, pointer(J),
        pointer(twist),
    )  # fmt: skip
