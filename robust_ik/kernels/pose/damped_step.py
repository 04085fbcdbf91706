"""One step of damped least squares towards a pose, inside limits, for one problem or for eight.

q ← clamp(q + Jᵀ (J Jᵀ + λ² I)⁻¹ e), λ² = μE + ε, E = ‖e‖². A joint at its limit that the gradient pushes outwards
leaves J before the solve. Steps are never rejected.

Source: Sugihara 2011 for λ² ∝ E.
"""

from __future__ import annotations

from typing import Any

from numba.extending import overload

from robust_ik.kernels.chain import chain_layout as links
from robust_ik.kernels.chain.joint_motion import LOCAL_WORLD_ALIGNED, joint_twists
from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.simd_lanes import LANES, Number, somewhere, where
from robust_ik.kernels.compiler.stack_memory import ONE, W8, W16, Pointer, by_eights, further, sizes, stack
from robust_ik.kernels.pose import pose_layout as lay

MU, FLOOR = 0.03, 1e-13
"""μ and ε of λ² = μE + ε.

Chosen: a larger μ creeps, a smaller one zigzags near singular poses; ε keeps pivots from zero.
"""
SIX = sizes(6)


@called
def columns(
    problem: Pointer, axes: Pointer, end: Pointer, error: Pointer, scale: float, J: Pointer, zero: Number
) -> None:
    """Fills J in columns of 8, unwanted rows zero, rotations times `scale`; `axes` become the joints' twists."""
    pack = further(problem, int(problem[lay.CHAIN]))
    joint_twists(pack, axes, end, axes, LOCAL_WORLD_ALIGNED, zero)
    for x in range(8 * int(problem[lay.COUNT])):
        J[x] = zero
    kind = int(problem[lay.TURN])
    for i in range(int(pack[links.JOINTS])):
        at = links.HEAD + i * links.STRIDE
        to, factor = 8 * int(pack[at + links.COLUMN]), pack[at + links.FACTOR]
        for r in range(3):
            J[to + r] = J[to + r] + (factor * problem[lay.ROWS + r]) * axes[6 * i + r]
        wx, wy, wz = axes[6 * i + 3], axes[6 * i + 4], axes[6 * i + 5]
        if kind == lay.SINGLE:
            wx, wy, wz = slope(error, wx, wy, wz)
        J[to + 3] = J[to + 3] + (factor * scale * problem[lay.ROWS + 3]) * wx
        J[to + 4] = J[to + 4] + (factor * scale * problem[lay.ROWS + 4]) * wy
        J[to + 5] = J[to + 5] + (factor * scale * problem[lay.ROWS + 5]) * wz


@inlined
def slope(error: Pointer, x: Number, y: Number, z: Number) -> tuple[Number, Number, Number]:
    """The rate w + ½ e × w + κ e × (e × w) at which the rotation vector e shrinks as the frame turns with w = x, y, z.

    Source: Chirikjian 2011, eq. (10.86): the inverse right Jacobian of SO(3).
    """
    a, b, c, half = error[9], error[10], error[11], error[8]
    square, inner = a * a + b * b + c * c, a * x + b * y + c * z
    kappa = inner * where(
        square > 1e-8, (1.0 - half) / where(square > 1e-8, square, square + 1.0), 0.0 * half + 1.0 / 12
    )
    return (
        half * x + 0.5 * (b * z - c * y) + kappa * a,
        half * y + 0.5 * (c * x - a * z) + kappa * b,
        half * z + 0.5 * (a * y - b * x) + kappa * c,
    )


def normal_matrix(J: Pointer, count: int, A: Pointer) -> None:
    """Fills the lower triangle of A = J Jᵀ, in 6 rows of 8, from the columns of J, of 8."""
    raise NotImplementedError


@overload(normal_matrix, strict=False)
def _normal_matrix(J: Any, count: Any, A: Any) -> Any:
    def side_by_side(J: Pointer, count: int, A: Pointer) -> None:
        for r in range(6):
            for c in range(r + 1):
                total = J[r] * J[c]
                for j in range(1, count):
                    total = total + J[8 * j + r] * J[8 * j + c]
                A[8 * r + c] = total

    def alone(J: Pointer, count: int, A: Pointer) -> None:
        whole, rows = by_eights(J), by_eights(A)
        j = whole[0]
        a0, a1, a2, a3, a4, a5 = J[0] * j, J[1] * j, J[2] * j, J[3] * j, J[4] * j, J[5] * j
        for i in range(1, count):
            j = whole[i]
            k = 8 * i
            a0, a1, a2 = a0 + J[k] * j, a1 + J[k + 1] * j, a2 + J[k + 2] * j
            a3, a4, a5 = a3 + J[k + 3] * j, a4 + J[k + 4] * j, a5 + J[k + 5] * j
        rows[0], rows[1], rows[2], rows[3], rows[4], rows[5] = a0, a1, a2, a3, a4, a5

    return side_by_side if J.dtype == LANES else alone


@called
def solve(A: Pointer, damping: Number, e: Pointer, y: Pointer, zero: Number) -> None:
    """Solves (A + damping) y = e by L D Lᵀ; A is overwritten."""
    inverse = stack(zero, ONE, W8)
    for j in range(6):
        d = A[9 * j] + damping
        for k in range(j):
            d = d - A[8 * j + k] * A[8 * j + k] * y[8 + k]
        y[8 + j] = d
        inverse[j] = 1.0 / d
        for i in range(j + 1, 6):
            entry = A[8 * i + j]
            for k in range(j):
                entry = entry - A[8 * i + k] * A[8 * j + k] * y[8 + k]
            A[8 * i + j] = entry * inverse[j]
    for i in range(6):
        total = e[i]
        for k in range(i):
            total = total - A[8 * i + k] * y[k]
        y[i] = total
    for i in range(6):
        y[i] = y[i] * inverse[i]
    for back in range(6):
        i = 5 - back
        total = y[i]
        for k in range(i + 1, 6):
            total = total - A[8 * k + i] * y[k]
        y[i] = total


@inlined
def along(J: Pointer, j: int, e: Pointer) -> Number:
    """Dot product of column j of J and e."""
    k = 8 * j
    return (J[k] * e[0] + J[k + 1] * e[1] + J[k + 2] * e[2]) + (J[k + 3] * e[3] + J[k + 4] * e[4] + J[k + 5] * e[5])


@called
def step(
    problem: Pointer,
    values: Pointer,
    axes: Pointer,
    end: Pointer,
    error: Pointer,
    scale: float,
    J: Pointer,
    moving: Pointer,
    zero: Number,
) -> None:
    """Makes one step in each lane where moving > 0.

    The excess of `moving` over 1, rad, is added to the limits of periodic joints.
    """
    count, loose = int(problem[lay.COUNT]), where(moving[0] > 1.0, moving[0] - 1.0, zero)
    columns(problem, axes, end, error, scale, J, zero)
    A, e, y = stack(zero, SIX, W8), stack(zero, ONE, W8), stack(zero, ONE, W16)
    for r in range(3):
        e[r], e[3 + r] = error[r], scale * error[3 + r]
    for j in range(count):
        at = lay.HEAD + j * lay.STRIDE
        room = problem[at + lay.PERIODIC] * loose
        low, high = problem[at + lay.LOWER] - room, problem[at + lay.UPPER] + room
        g, v = along(J, j, e), values[j]
        keep = where((v <= low) & (g < 0.0), zero, where((v >= high) & (g > 0.0), zero, zero + 1.0))
        if somewhere(keep < 1.0):
            for r in range(6):
                J[8 * j + r] = J[8 * j + r] * keep
    normal_matrix(J, count, A)
    E = error[6] + (scale * scale) * error[7]
    solve(A, MU * E + FLOOR, e, y, zero)
    for j in range(count):
        at = lay.HEAD + j * lay.STRIDE
        room = problem[at + lay.PERIODIC] * loose
        low, high = problem[at + lay.LOWER] - room, problem[at + lay.UPPER] + room
        v = values[j]
        new = v + along(J, j, y)
        new = where(new < low, low, where(new > high, high, new))
        values[j] = where(moving[0] > 0.0, new, v)
