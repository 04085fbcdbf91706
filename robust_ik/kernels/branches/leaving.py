"""Whether a singular solution can be left while the tool stands still: it lies on a self-motion then."""

from __future__ import annotations

from robust_ik.kernels.branches.branches_layout import JOINTS
from robust_ik.kernels.branches.curve_tracing import eliminated, tangent
from robust_ik.kernels.branches.loop_state import SIX, change, loop_state
from robust_ik.kernels.branches.settling import settle
from robust_ik.kernels.compiler.compiling import called
from robust_ik.kernels.compiler.stack_memory import ONE, W16, Pointer, stack

AWAY = 0.02
"""How far a solution is tried to be left, rad and units of length. At a root of order five the error is 3e-9 there."""
STAYS = 0.5
"""Part of that way that must remain behind Newton's method: from beside a multiple root it comes back to it."""
TWO_LOST = 1e-6
"""A fifth pivot up to this part of the first one counts as zero."""


@called
def is_on_curve(axes: Pointer, slides: Pointer, g: Pointer, q: Pointer) -> bool:
    """Whether solutions lie to a side of q, (6,), along what its Jacobian loses; true where that loses two motions."""
    J, twist, columns = stack(0.0, SIX, SIX), stack(0.0, ONE, W16), stack(0.0, ONE, W16)
    along, there = stack(0.0, ONE, W16), stack(0.0, ONE, SIX)
    loop_state(axes, slides, JOINTS, q, g, g, 6, J, twist)
    if not eliminated(J, 6, JOINTS, JOINTS - 1, twist, columns) > TWO_LOST:
        return True
    tangent(J, JOINTS, JOINTS - 1, columns, along)
    for turn in range(2):
        side = 1.0 - 2.0 * turn
        for k in range(JOINTS):
            there[k] = q[k] + side * AWAY * along[k]
        is_one, _, _, _ = settle(axes, slides, g, there)
        left = 0.0
        for k in range(JOINTS):
            left += change(there[k] - q[k], slides[k]) * along[k]
        if is_one and STAYS * AWAY < side * left < AWAY / STAYS:
            return True
    return False
