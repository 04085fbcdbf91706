"""Gains and dampings that several filters share, for arrays and for compiled code; and `apply_gains`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_measures, check_leading_axes, checked_parameter
from robust_ik.errors import InputError
from robust_ik.kernels.compiler.where import where
from robust_ik.kinematics.svd import ThinSVD

Quantity = Any
"""An array, or a number in compiled code."""


def kept_or_zero(kept: Quantity, s: Quantity) -> Quantity:
    """1/σ if it is kept, else 0."""
    return where(kept, 1.0 / where(kept, s, 1.0), 0.0)


def damped(s: Quantity, squared_damping: Quantity) -> Quantity:
    """σ/(σ² + λ²), and 0 at σ = 0; exactly 1/σ where λ² = 0. No square can overflow or underflow."""
    length = np.hypot(s, np.sqrt(squared_damping))
    length = where(s > 0, length, 1.0)
    return s / length / length


def fading(s: Quantity, threshold: Quantity, damping: Quantity) -> Quantity:
    """λ²(σ) = (1 − (σ/ε)²) λ_max² below the threshold ε and 0 above.

    Source: Chiaverini, Egeland and Kanestrøm 1991; Kim, Marani, Chung and Yuh, eq. (32).
    """
    ratio = np.minimum(s, threshold) / threshold
    return (1.0 - ratio**2) * damping**2


def damped_gain(s: ArrayLike, squared_damping: ArrayLike) -> Array:
    """σ/(σ² + λ²), and 0 at σ = 0; exactly 1/σ where λ² = 0.

    Args:
        s: Singular values, any shape.
        squared_damping: λ² ≥ 0, broadcast against `s`.
    """
    return np.asarray(damped(np.asarray(s, dtype=float), squared_damping))


def fading_damping(s: ArrayLike, threshold: float, damping: float) -> Array:
    """λ²(σ) = (1 − (σ/ε)²) λ_max² below the threshold ε and 0 above, any shape.

    Source: Chiaverini, Egeland and Kanestrøm 1991; Kim, Marani, Chung and Yuh, eq. (32).
    """
    return np.asarray(fading(np.asarray(s, dtype=float), threshold, damping))


def check_level(name: str, absolute: float | None, gamma: float | None) -> None:
    """Raises unless a level of σ is given either as such or as the fraction γ of σ₁, and is in range.

    Args:
        name: What the absolute level is called.
        absolute: The level in the units of σ, or None.
        gamma: The level relative to σ₁, or None.

    Raises:
        InputError: Both or neither are given; the level is not > 0; γ is not between 0 and 1.
    """
    if absolute is not None and gamma is not None:
        raise InputError(f"give {name} or gamma, not both: got {name}={absolute!r} and gamma={gamma!r}")
    if gamma is None:
        checked_parameter(name, absolute, above=0)
    else:
        checked_parameter("gamma", gamma, above=0, below=1)


def falling_zero(function: Callable[[float], float], low: float, high: float) -> float:
    """The zero of a falling function, > 0 at low and < 0 at high: by bisection, to rounding."""
    middle = (low + high) / 2
    while low < middle < high:
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
        middle = (low + high) / 2
    return middle


def apply_gains(decomposition: ThinSVD, gains: Array, xdot: ArrayLike) -> Array:
    """V diag(φ) Uᵀ ẋ, (..., n), for gains φ (..., k) and ẋ (..., m)."""
    xdot = as_measures(xdot, "xdot", (decomposition.U.shape[-2],))
    return applied(decomposition, gains, xdot)


def applied(decomposition: ThinSVD, gains: Array, xdot: Array) -> Array:
    """`apply_gains` without checks of ẋ."""
    check_leading_axes("J", decomposition.s.shape[:-1], "xdot", xdot.shape[:-1])
    components = np.einsum("...mk,...m->...k", decomposition.U, xdot)
    return np.asarray(np.einsum("...kn,...k->...n", decomposition.Vt, gains * components))
