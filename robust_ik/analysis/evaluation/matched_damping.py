"""Damping that changes M = J Jᵀ as much as Dułęba's clamp does, for comparison with the clamp."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.analysis.evaluation.modification import matching_squared_damping
from robust_ik.checks import Array, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, SingularValueFilter
from robust_ik.inverses.damping_formulas import damped_gain


@dataclass(frozen=True)
class DulebaMatched(SingularValueFilter):
    """φᵢ = σᵢ/(σᵢ² + λ) with λ = Σ max(d_min² − σⱼ², 0)/k, so that f₁ = f₂: Algorithm 1 of the source.

    For comparison with `DulebaClamp(floor)`, Algorithm 2; λ is 0 if no singular value is below the floor.

    Watch for: the largest gain is not 1/d_min, as with the clamp, but grows with the number of rows: see `peak`.

    Attributes:
        floor: d_min > 0 of the clamp that it is matched with, in the units of σ.

    Source: Duleba 2023, eqs. (11), (24) and section 5, with f₁ = f₂ of eqs. (25), (26).
    """

    source: ClassVar[str] = "Duleba 2023, eq. (11), f₁ = f₂"
    card: ClassVar[Card] = Card(
        formula="σ/(σ² + λ), λ = Σ max(d_min² − σ², 0)/k",
        largest_gain="k/(2 d_min √(k − 1)) for k ≥ 2 singular values, 1/d_min for one",
        gain_at_zero="0",
        exact="all directions where σ_k ≥ d_min",
        continuity="continuous",
    )
    floor: float = 1e-2

    def __post_init__(self) -> None:
        checked_parameter("floor", self.floor, above=0)

    def gains(self, s: ArrayLike) -> Array:
        """σ/(σ² + λ)."""
        s = np.asarray(s, dtype=float)
        return damped_gain(s, matching_squared_damping(s, self.floor)[..., None])

    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """All directions if σ_k ≥ d_min, else none."""
        s = np.asarray(s, dtype=float)
        return np.array(np.broadcast_to(s[..., -1:] >= self.floor, s.shape))

    def largest_gain(self, sigma_max: float) -> float:
        """Infinite: it grows as √k/(2 d_min) with the number k of singular values; for a given k see `peak`."""
        return math.inf if sigma_max > 0 else 0.0

    def peak(self, k: int) -> float:
        """The largest φ of k singular values: one at d_min/√(k − 1), the others at d_min or more.

        Args:
            k: Number of singular values, at least 1.
        """
        if k < 1:
            raise InputError(f"k must be at least 1, got {k}")
        return (1.0 if k == 1 else k / (2 * math.sqrt(k - 1))) / self.floor
