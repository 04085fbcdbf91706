"""Limits how far a level may go along each direction in one step, so that it does not overshoot, for any inverse.

Along a direction with singular value σ an inverse with gain φ asks for φ u·ẋ. During a step the Jacobian changes: the
level's velocity along that direction changes by up to Δt ‖ẋ‖ σ₁ φ/σ of itself: |ẋ·∂J| along a unit motion twice is
below ‖ẋ‖ σ₁ on the eight arms in space of a test, and below twice that on a planar one, which may overshoot when
folded. If the change is more than twice the velocity, the arm goes back and forth about the place where it should rest,
above all at the end of its reach. So steady motion has φ ≤ 2 σ/(Δt ‖ẋ‖ σ₁), or

    Δt |v·q̇| ≤ 2 (σ/σ₁) |u·ẋ|/‖ẋ‖,

in rad, and for joints that slide in lengths of the controller's scale. Noise and lag may still shake a steady motion.
This does not change an exact inverse where σ² ≥ ½ Δt ‖ẋ‖ σ₁, and J-PARSE nowhere if γ² ≥ ½ Δt ‖ẋ‖/σ₁: fast motion in
long steps has wide margins around singularities, slow motion near a target hardly any.
"""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.within_bounds.null_space import Reduced
from robust_ik.kinematics.svd import length


def steadied(motion: Array, reduced: Reduced, wanted: Array, dt: float) -> Array:
    """A level's motion, (n,), shortened along directions in which it would overshoot; the same array if there are none.

    Args:
        motion: The motion that the level's inverse wants.
        reduced: The level's Jacobian in the freedom left to it.
        wanted: ẋ, the task velocity that is still missing, (m,).
        dt: Length of a step, s.
    """
    rank, size = reduced.rank, length(wanted)
    if rank == 0 or size == 0.0 or dt == 0.0:
        return motion
    along = reduced.motions @ motion
    most = 2.0 / dt * (reduced.s[:rank] / reduced.sigma_max) * np.abs(wanted / size @ reduced.U[:, :rank])
    if (np.abs(along) <= most * (1 + 1e-12)).all():
        return motion
    return np.asarray(motion + (np.clip(along, -most, most) - along) @ reduced.motions)
