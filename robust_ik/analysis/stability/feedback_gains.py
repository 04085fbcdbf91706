"""Gains and time steps for which the error decreases, for a target that can be reached.

K is a positive number in 1/s, or one per task row, (m,).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.analysis.stability.gain_probe import supremum
from robust_ik.checks import Array, as_array, checked_parameter
from robust_ik.checks.public_arguments import computed
from robust_ik.errors import InputError
from robust_ik.inverses import SingularValueFilter
from robust_ik.kinematics.svd import svd


@computed
def largest_share(inverse: SingularValueFilter, sigma_max: float) -> float:
    """The least upper bound of σφ(σ) over 0 < σ ≤ σ₁ = sigma_max: the largest fraction given of what is asked.

    max(1, p) for J-PARSE; σ₁²/(σ₁² + λ²) for damped least squares.

    Watch for: it is probed with two singular values, σ₁ and σ, only; the result may not hold for a filter that depends
    on more of them, on their product for example.

    Args:
        inverse: The filter.
        sigma_max: The largest singular value that will be met, > 0.
    """
    return supremum(inverse, sigma_max, lambda sigma, phi: sigma * phi)


@computed
def largest_stable_gain(inverse: SingularValueFilter, dt: float, sigma_max: float) -> float:
    """The largest entry k of K with k d̄ Δt ≤ 2, d̄ = sup σφ(σ), 1/s: ½eᵀKe does not grow, at any q.

    Sharp for K = kI, where an error along a direction with d̄ neither grows nor shrinks at equality; sufficient for any
    diagonal K. It holds to first order in Δt q̇: J is taken as constant during a step.

    Args:
        inverse: The filter.
        dt: Δt > 0, s.
        sigma_max: The largest singular value that will be met, > 0.

    Source: J-PARSE, eq. (50), with the bound D UᵀKU D ≤ k D² in place of its appendix A.
    """
    share = largest_share(inverse, sigma_max)
    step = checked_parameter("dt", dt, above=0)
    return 2 / (step * share) if share > 0 else math.inf


@computed
def largest_stable_dt(inverse: SingularValueFilter, gain: ArrayLike, sigma_max: float) -> float:
    """The largest Δt with k d̄ Δt ≤ 2, s; see `largest_stable_gain`.

    Args:
        inverse: The filter.
        gain: K, one number or one per task row, 1/s.
        sigma_max: The largest singular value that will be met, > 0.
    """
    largest = float(np.max(positive_gain(gain)))
    return 2 / (largest * largest_share(inverse, sigma_max))


@computed
def conservative_gain(inverse: SingularValueFilter, dt: float, rows: int, sigma_max: float) -> float:
    """The paper's own bound k ≤ 2/(m d̄ Δt), 1/s: m times smaller than `largest_stable_gain`, by diagonal dominance.

    The paper prints p for d̄ = max(1, p): for p < 1/m that would allow gains that make regular directions unstable.

    Args:
        inverse: The filter.
        dt: Δt > 0, s.
        rows: m, the number of task rows.
        sigma_max: The largest singular value that will be met, > 0.

    Source: J-PARSE, eq. (67).
    """
    return largest_stable_gain(inverse, dt, sigma_max) / checked_parameter("rows", rows, least=1)


@computed
def error_factors(inverse: SingularValueFilter, J: ArrayLike, gain: float, dt: float) -> Array:
    """1 − Δt k dᵢ with dᵢ = σᵢφ(σᵢ): the factor of one step on the error along uᵢ, for K = kI, (..., k).

    Stable if all lie in (−1, 1). 1 is a direction in which nothing happens; it is also the factor of directions that n
    < m joints leave over.

    Args:
        inverse: The filter.
        J: Jacobian, (..., m, n).
        gain: k > 0, 1/s.
        dt: Δt > 0, s.
    """
    s = svd(J).s
    product = checked_parameter("gain", gain, above=0) * checked_parameter("dt", dt, above=0)
    return np.asarray(1 - product * s * inverse.gains(s))


@computed
def lyapunov(error: ArrayLike, gain: ArrayLike) -> Array:
    """V = ½ eᵀKe, shape (...): it falls in continuous time. ½‖e‖² need not, if K is no multiple of I.

    Args:
        error: Target minus current, (..., m).
        gain: K, one number or one per task row, 1/s.

    Source: J-PARSE, eqs. (32) to (43), which hold with this V only.
    """
    error = as_array(error, "error", (None,))
    return np.asarray(0.5 * np.sum(positive_gain(gain, error.shape[-1]) * error**2, axis=-1))


@computed
def lyapunov_rate(inverse: SingularValueFilter, J: ArrayLike, error: ArrayLike, gain: ArrayLike) -> Array:
    """V̇ = −(Ke)ᵀ J J# (Ke) ≤ 0 for a target at rest, shape (...); negative while some part of Ke is given.

    Args:
        inverse: The filter.
        J: Jacobian, (..., m, n).
        error: Target minus current, (..., m).
        gain: K, one number or one per task row, 1/s.

    Source: J-PARSE, eq. (42).
    """
    decomposition = svd(J)
    U, s = decomposition.U, decomposition.s
    command = positive_gain(gain, U.shape[-2]) * as_array(error, "error", (U.shape[-2],))
    y = np.einsum("...mk,...m->...k", U, command)
    return np.asarray(-np.sum(s * inverse.gains(s) * y**2, axis=-1))


@computed
def decrease_matrix(inverse: SingularValueFilter, J: ArrayLike, gain: ArrayLike, dt: float) -> Array:
    """G − (Δt/2) G K G with G = J J#, (..., m, m): one step changes V by −Δt (Ke)ᵀ(…)(Ke), J being constant.

    If no eigenvalue is negative, V does not grow for any error. It is the paper's S in world axes, U S Uᵀ.

    Args:
        inverse: The filter.
        J: Jacobian, (..., m, n).
        gain: K, one number or one per task row, 1/s.
        dt: Δt > 0, s.

    Source: J-PARSE, eqs. (44) to (49).
    """
    dt = checked_parameter("dt", dt, above=0)
    J = as_array(J, "J", (None, None))
    G = J @ inverse.matrix(J)
    K = np.broadcast_to(positive_gain(gain, G.shape[-1]), G.shape[:-1])
    return np.asarray(G - dt / 2 * G @ (K[..., None] * G))


@computed
def projector_leak(inverse: SingularValueFilter, J: ArrayLike) -> Array:
    """‖J (I − J#J)‖₂ = max σᵢ|1 − σᵢφ(σᵢ)|: the task speed that I − J#J leaks per secondary joint speed, shape (...).

    For damped least squares it is up to λ/2, at any distance from singularities, and holds the task off its target;
    `robust_ik.null_projector` leaks nothing.

    Args:
        inverse: The filter.
        J: Jacobian, (..., m, n).
    """
    s = svd(J).s
    return np.asarray(np.max(s * np.abs(1 - s * inverse.gains(s)), axis=-1))


def positive_gain(gain: ArrayLike, rows: int | None = None) -> Array:
    """The gain K, checked: a positive number, or one per task row."""
    value = as_array(gain, "gain", ())
    if value.ndim > 1 or value.size == 0 or not (value > 0).all():
        raise InputError(f"gain must be one number > 0 or one per task row, got {gain!r}")
    if value.ndim == 1 and rows is not None and value.size != rows:
        raise InputError(f"gain must have one entry or {rows}, one per task row, got {value.size}")
    return value
