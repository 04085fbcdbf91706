"""How much a damping or a clamp changes a Jacobian, and how far it moves it away from its singularities. Arrays only.

Dułęba compares two cures of M = J Jᵀ on equal terms: adding λI (damped least squares, λ = damping²), and raising every
singular value to at least d_min, the floor. Singular values are those of a thin decomposition, `robust_ik.svd(J).s`,
(..., k) with k = min(m, n): for m > n, JᵀJ, which is smaller, takes the place of M.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, check_leading_axes, checked_parameter
from robust_ik.checks.public_arguments import computed
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import svd


@computed
def modification_by_damping(s: ArrayLike, squared_damping: ArrayLike) -> Array:
    """f₁ = k λ: by how much adding λI raises the trace of M, shape (...).

    Args:
        s: Singular values, (..., k).
        squared_damping: λ ≥ 0, the *square* of the damping of `DampedLeastSquares`, shape (...).

    Source: Duleba 2023, eq. (25).
    """
    s = _spectrum(s)
    added = _not_negative(squared_damping)
    check_leading_axes("squared_damping", added.shape, "s", s.shape[:-1])
    return np.asarray(s.shape[-1] * (added + np.zeros(s.shape[:-1])))


@computed
def modification_by_clamp(s: ArrayLike, floor: float) -> Array:
    """f₂ = Σ max(d_min² − σᵢ², 0): by how much raising every σ to the floor raises the trace of M, shape (...).

    Args:
        s: Singular values, (..., k).
        floor: d_min > 0.

    Source: Duleba 2023, eq. (26).
    """
    floor = checked_parameter("floor", floor, above=0)
    return np.asarray(np.maximum(floor**2 - _spectrum(s) ** 2, 0.0).sum(axis=-1))


@computed
def matching_squared_damping(s: ArrayLike, floor: float) -> Array:
    """λ = f₂/k: the additive term that modifies M as much as the clamp does, f₁ = f₂, shape (...).

    Watch for: it is the square of a damping, `DampedLeastSquares(damping=√λ)`, and 0 if no σ is below the floor.

    Args:
        s: Singular values, (..., k).
        floor: d_min > 0.

    Source: Duleba 2023, section 4, f₁ = f₂ with eqs. (25), (26).
    """
    s = _spectrum(s)
    return np.asarray(modification_by_clamp(s, floor) / s.shape[-1])


@computed
def safety_by_damping(s: ArrayLike, squared_damping: ArrayLike) -> Array:
    """h₁ = σ_k² + λ: the smallest eigenvalue of M after the damping, shape (...).

    Args:
        s: Singular values, (..., k), in descending order.
        squared_damping: λ ≥ 0, shape (...).

    Source: Duleba 2023, eq. (29).
    """
    return np.asarray(_spectrum(s)[..., -1] ** 2 + _not_negative(squared_damping))


@computed
def safety_by_clamp(s: ArrayLike, floor: float) -> Array:
    """h₂ = max(σ_k, d_min)²: the smallest eigenvalue of M after the clamp, shape (...).

    The paper prints d_min², which holds if σ_k is clamped; otherwise it would be less than σ_k².

    Args:
        s: Singular values, (..., k), in descending order.
        floor: d_min > 0.

    Source: Duleba 2023, eq. (29).
    """
    floor = checked_parameter("floor", floor, above=0)
    return np.asarray(np.maximum(_spectrum(s)[..., -1], floor) ** 2)


@dataclass(frozen=True, eq=False)
class Comparison:
    """Comparison of damping and clamp that modify M by the same amount; arrays over the leading axes of J.

    With c singular values below the floor, the clamp gets at least as far from the singularity, strictly farther if
    0 < c < k; for c = 0 both change nothing, and for c = k they are equal if all σ are.

    Attributes:
        squared_damping: The matching λ.
        modification: f₁ = f₂.
        damped: h₁, the smallest eigenvalue of M with the damping.
        clamped: h₂, the same with the clamp.

    Source: Duleba 2023, eqs. (25) to (31).
    """

    squared_damping: Array
    modification: Array
    damped: Array
    clamped: Array


@computed
def compare_damping_and_clamp(J: ArrayLike, floor: float) -> Comparison:
    """Compares how far damping and clamp get from the singularity for the same modification.

    Args:
        J: Jacobian, (..., m, n).
        floor: d_min > 0.
    """
    s = svd(J).s
    squared_damping = matching_squared_damping(s, floor)
    return Comparison(
        squared_damping=squared_damping,
        modification=modification_by_clamp(s, floor),
        damped=safety_by_damping(s, squared_damping),
        clamped=safety_by_clamp(s, floor),
    )


def _spectrum(s: ArrayLike) -> Array:
    s = as_array(s, "s", (None,))
    if s.shape[-1] == 0 or (s < 0).any() or (np.diff(s, axis=-1) > 0).any():
        raise InputError(f"s must be singular values ≥ 0 in descending order, got {s}")
    return s


def _not_negative(squared_damping: ArrayLike) -> Array:
    value = as_array(squared_damping, "squared_damping", ())
    if (value < 0).any():
        raise InputError(f"squared_damping must be ≥ 0, got {value}")
    return value
