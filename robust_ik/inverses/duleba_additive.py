"""Duleba's additive damping: J Jᵀ is made regular by adding a diagonal matrix, which may be scaled to its rows."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, check_leading_axes, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, RobustInverse
from robust_ik.inverses.damping_formulas import applied, damped_gain
from robust_ik.kinematics.svd import SMALLEST_SIGMA, svd

Variant = Literal["plain", "scaled", "floored"]


@dataclass(frozen=True)
class DulebaAdditive(RobustInverse):
    """J^T (J Jᵀ + λ diag(f))⁻¹ with f by the rows Jᵢ of J.

    * "plain", eq. (11): f = 1. Damped least squares with damping √λ.
    * "scaled", eq. (12): fᵢ = ‖Jᵢ‖². The unit of a row does not matter: P(SJ) S = P(J) for diagonal S > 0.
    * "floored", eq. (13): fᵢ = max(‖Jᵢ‖², ε).

    It is the filter σ/(σ² + λ) of D⁻¹J, times D⁻¹, with D = diag(√f). A row of zeros, along which nothing can move,
    is left out.

    Watch for: λ is *added as it is*: it is the square of what other inverses call damping. "scaled" has no largest
    gain: a row that almost vanishes gets a gain of up to 1/(2√λ ‖Jᵢ‖).

    Attributes:
        squared_damping: λ > 0; "plain": in the units of σ²; else a pure number.
        variant: "plain", "scaled" or "floored".
        floor: ε > 0, the least fᵢ of "floored", in the units of σ².

    Source: Duleba 2023, eq. (11) to (13).
    """

    source: ClassVar[str] = "Duleba 2023, eq. (11)-(13)"
    card: ClassVar[Card] = Card(
        formula="Jᵀ(JJᵀ + λ diag(f))⁻¹; f = 1, ‖Jᵢ‖² or max(‖Jᵢ‖², ε)",
        largest_gain="1/(2√λ), none, 1/(2√(λε))",
        gain_at_zero="0",
        exact="nowhere",
        continuity="continuous; “scaled” not where a row vanishes",
    )
    squared_damping: float = 0.0025
    variant: Variant = "scaled"
    floor: float = 1e-4

    def __post_init__(self) -> None:
        checked_parameter("squared_damping", self.squared_damping, above=0)
        checked_parameter("floor", self.floor, above=0)
        if not isinstance(self.variant, str) or self.variant not in get_args(Variant):
            raise InputError(f"variant must be one of {', '.join(get_args(Variant))}, got {self.variant!r}")

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """Joint velocities Jᵀ (J Jᵀ + λ diag(f))⁻¹ ẋ; see `RobustInverse.solve`."""
        J = as_array(J, "J", (None, None))
        scale = self._row_scale(J)
        decomposition = svd(J / scale[..., None])
        xdot = as_array(xdot, "xdot", (J.shape[-2],))
        check_leading_axes("J", J.shape[:-2], "xdot", xdot.shape[:-1])
        gains = damped_gain(decomposition.s, self.squared_damping)
        with np.errstate(over="ignore", invalid="ignore"):  # rows may be in any unit
            return as_array(applied(decomposition, gains, xdot / scale), "q̇, of an xdot so large,", ())

    def _row_scale(self, J: Array) -> Array:
        """√f, (..., m)."""
        if self.variant == "plain":
            return np.ones(J.shape[:-1])
        # Divided by the largest entry first, so that no square underflows.
        largest = np.abs(J).max(axis=-1, initial=SMALLEST_SIGMA)
        with np.errstate(over="ignore"):
            length = np.minimum(largest * np.linalg.norm(J / largest[..., None], axis=-1), sys.float_info.max)
        if self.variant == "floored":
            return np.asarray(np.maximum(length, math.sqrt(self.floor)))
        return np.asarray(np.where(length <= SMALLEST_SIGMA, 1.0, length))

    def largest_gain(self, sigma_max: float) -> float:
        """A bound: the peak 1/(2√(λ ε)) of σ/(σ² + λ ε), with ε = 1 for "plain"; infinite for "scaled"."""
        if self.variant == "scaled":
            return math.inf if sigma_max > 0 else 0.0
        added = self.squared_damping * (self.floor if self.variant == "floored" else 1.0)
        # ‖Jᵀ (J Jᵀ + A)⁻¹‖ with A ≥ added · I; if no more is known of A it is also at most σ₁/added.
        return min(1 / (2 * math.sqrt(added)), sigma_max / added)
