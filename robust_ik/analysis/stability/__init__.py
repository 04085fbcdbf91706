"""Stability of a control loop, known before it runs: gains, time steps, chatter at singularities. Arrays only.

The loop is ẋ = K e, q̇ = J# ẋ, q ← q + Δt q̇, for a target at rest and e = target − current. `feedback_gains` is
for targets that can be reached; `chatter` for those that cannot, where the arm stretches to a singularity and may swing
about it.
"""

from robust_ik.analysis.stability.chatter import (
    critical_dt,
    limit_cycle_amplitude,
    sigma_rate,
    slope_at_zero,
    steepest_slope,
)
from robust_ik.analysis.stability.feedback_gains import (
    conservative_gain,
    decrease_matrix,
    error_factors,
    largest_share,
    largest_stable_dt,
    largest_stable_gain,
    lyapunov,
    lyapunov_rate,
    projector_leak,
)
from robust_ik.analysis.stability.unequal_gains import block_gains_are_stable, smallest_eigenvalue_along

__all__ = [
    "block_gains_are_stable",
    "conservative_gain",
    "critical_dt",
    "decrease_matrix",
    "error_factors",
    "largest_share",
    "largest_stable_dt",
    "largest_stable_gain",
    "limit_cycle_amplitude",
    "lyapunov",
    "lyapunov_rate",
    "projector_leak",
    "sigma_rate",
    "slope_at_zero",
    "smallest_eigenvalue_along",
    "steepest_slope",
]
