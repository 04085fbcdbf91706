"""Chatter: the swing about a singularity when the arm stretches towards a target out of reach.

Along the lost direction the command does not vanish, uᵀẋ → w ≠ 0 ("lost speed"), while σ → 0. Let y be the joint motion
along the unit vector v from the singularity, and a = |dσ/dy|. One step takes y to y − Δt w φ(a|y|) sign y, which either
dies out or ends in a swing between two sides. Linear stability analysis does not show it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.analysis.stability.gain_probe import gains_at, grid, supremum
from robust_ik.checks import Array, checked_parameter
from robust_ik.checks.public_arguments import computed
from robust_ik.errors import InputError
from robust_ik.inverses import SingularValueFilter
from robust_ik.kinematics.singular_value_gradients import singular_value_gradients
from robust_ik.kinematics.svd import svd

REFINEMENTS, PER_REFINEMENT = 6, 41
"""Divisions of an interval, and points of each: 40⁶ takes the 4 % between grid points to 1e-11 of σ."""


@computed
def slope_at_zero(inverse: SingularValueFilter, sigma_max: float) -> float:
    """φ'(0): 1/λ² for damped least squares, p/(γσ₁)² for J-PARSE; infinite if φ(0⁺) ≠ 0.

    Args:
        inverse: The filter.
        sigma_max: σ₁ > 0 near the singularity.
    """
    if not isinstance(inverse, SingularValueFilter):
        raise InputError(f"only a singular-value filter has a gain φ(σ) to probe, got {inverse!r}")
    sigma = checked_parameter("sigma_max", sigma_max, above=0) * np.array([1e-150, 1e-140])
    nearer, farther = gains_at(inverse, sigma_max, sigma) / sigma
    # A finite slope is the same at both; if φ(0⁺) > 0, or φ grows like a root, it is ever steeper.
    return math.inf if nearer > farther * (1 + 1e-6) else float(nearer)


@computed
def steepest_slope(inverse: SingularValueFilter, sigma_max: float) -> float:
    """The least upper bound of φ(σ)/σ over 0 < σ ≤ σ₁: at least φ'(0); it decides about swings of any size.

    It is max(1, p)/(γσ₁)² for J-PARSE, and 1/τ² for a truncation at τ, whose φ'(0) is 0.

    Args:
        inverse: The filter.
        sigma_max: σ₁ > 0 near the singularity.
    """
    if math.isinf(slope := slope_at_zero(inverse, sigma_max)):
        return slope
    return max(slope, supremum(inverse, sigma_max, lambda sigma, phi: phi / sigma))


@computed
def sigma_rate(J: ArrayLike, hessian: ArrayLike) -> Array:
    """The rate a = |dσ_k/dy| at which the smallest singular value grows with joint motion along its own v, shape (...).

    Its unit is that of σ per rad or m.

    Watch for: σ_k must be a simple singular value; a is 0 if motion along v does not leave the singularity.

    Args:
        J: Jacobian at, or near, the singularity, (..., m, n).
        hessian: ∂J/∂q there, (..., m, n, n).
    """
    gradient = singular_value_gradients(J, hessian)[..., -1, :]
    return np.asarray(np.abs(np.sum(gradient * svd(J).Vt[..., -1, :], axis=-1)))


@computed
def critical_dt(slope: float, rate: float, lost_speed: float) -> float:
    """The time step above which the arm swings about the singularity, 2/(slope · a |w|), s; infinite if it never does.

    With `slope_at_zero` a smaller Δt makes small swings die out, and a larger one makes them grow. With
    `steepest_slope` a smaller Δt makes swings of any size die out.

    Args:
        slope: φ'(0) or sup φ(σ)/σ, ≥ 0, possibly infinite.
        rate: a ≥ 0, from `sigma_rate`.
        lost_speed: w = uᵀẋ along the lost direction, in task units/s.
    """
    slope = slope if slope == math.inf else checked_parameter("slope", slope, least=0)
    pull = checked_parameter("rate", rate, least=0) * abs(checked_parameter("lost_speed", lost_speed))
    return 2 / (slope * pull) if slope > 0 and pull > 0 else math.inf


@computed
def limit_cycle_amplitude(
    inverse: SingularValueFilter, sigma_max: float, *, dt: float, rate: float, lost_speed: float
) -> float:
    """The largest swing ±y about the singularity that repeats itself every two steps, rad or m along v; 0 if none.

    It solves Δt w φ(a y) = 2y. If φ(0⁺) = φ₀ > 0 there always is one, Δt φ₀ |w|/2 for small Δt; for damped least
    squares it is √(Δt |w| a/2 − λ²)/a above the critical Δt. It is attractive if φ grows there with σ, and half of the
    whole swing if φ is constant; if φ falls, swings may become larger. It is infinite if it would need σ > σ₁.

    Args:
        inverse: The filter.
        sigma_max: σ₁ > 0 near the singularity.
        dt: Δt > 0, s.
        rate: a > 0, from `sigma_rate`.
        lost_speed: w = uᵀẋ along the lost direction, in task units/s.
    """
    a = checked_parameter("rate", rate, above=0)
    wanted = critical_dt(1.0, a, lost_speed) / checked_parameter("dt", dt, above=0)
    sigma = grid(inverse, sigma_max)
    last = np.flatnonzero(gains_at(inverse, sigma_max, sigma) / sigma >= wanted)
    if not last.size:
        return 0.0
    if last[-1] == sigma.size - 1:
        return math.inf
    for _ in range(REFINEMENTS):
        sigma = np.linspace(sigma[last[-1]], sigma[last[-1] + 1], PER_REFINEMENT)
        last = np.flatnonzero(gains_at(inverse, sigma_max, sigma) / sigma >= wanted)
    return float(sigma[last[-1]]) / a
