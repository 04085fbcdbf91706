"""Chiaverini's damped least squares: damping begins when the smallest singular value falls below a threshold."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import checked_parameter
from robust_ik.inverses.base import Card
from robust_ik.inverses.damping_formulas import Quantity, damped, damped_gain, fading, fading_damping
from robust_ik.inverses.gain_formula import GainFormula


@dataclass(frozen=True)
class Chiaverini(GainFormula):
    """φᵢ = σᵢ/(σᵢ² + λ²(σ_k)) with λ² = (1 − (σ_k/ε)²) λ_max² for a smallest σ_k < ε, and 0 above.

    Watch for: one small singular value damps every direction. With λ_max < ε/√2 the largest gain lies inside the
    damped region and exceeds 1/ε; with λ_max ≥ ε/√2 it is 1/ε, at σ = ε.

    Attributes:
        threshold: ε > 0, the σ_k above which nothing is damped, in the units of σ.
        damping: λ_max > 0, the damping at σ_k = 0, in the units of σ.

    Source: Chiaverini, Egeland and Kanestrøm 1991; Kim, Marani, Chung and Yuh, eq. (32).
    """

    source: ClassVar[str] = "Chiaverini-Egeland-Kanestrøm 1991"
    card: ClassVar[Card] = Card(
        formula="σ/(σ² + λ²(σ_k)), λ² = (1 − (σ_k/ε)²)λ_max² below ε",
        largest_gain="1/ε for λ_max ≥ ε/√2, else 1/(2λ_max √(1 − (λ_max/ε)²))",
        gain_at_zero="0",
        exact="all directions where σ_k ≥ ε",
        continuity="continuous",
    )
    threshold: float = 0.05
    damping: float = 0.07

    def __post_init__(self) -> None:
        checked_parameter("threshold", self.threshold, above=0)
        checked_parameter("damping", self.damping, above=0)

    @staticmethod
    def formula(
        s: Quantity, largest: Quantity, smallest: Quantity, product: Quantity, place: Quantity, p: Any
    ) -> Quantity:
        """σ/(σ² + λ²(σ_k))."""
        return damped(s, fading(smallest, p[0], p[1]))

    @property
    def parameters(self) -> tuple[float, ...]:
        """ε, λ_max."""
        return (self.threshold, self.damping)

    def largest_gain(self, sigma_max: float) -> float:
        """The peak of σ/(σ² + λ²(σ)): for a given σ the damping is least if σ_k = σ."""
        return largest_fading_gain(sigma_max, self.threshold, self.damping)

    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """All directions if σ_k ≥ ε, else none."""
        s = np.asarray(s, dtype=float)
        return np.array(np.broadcast_to(s[..., -1:] >= self.threshold, s.shape))


def largest_fading_gain(sigma_max: float, threshold: float, damping: float, floor: float = 0.0) -> float:
    """The largest σ/(σ² + λ²(σ) + β²) over 0 ≤ σ ≤ sigma_max, λ² fading from λ_max² to 0 at the threshold ε.

    Below ε the denominator is (1 − (λ_max/ε)²) σ² + λ_max² + β²; above it is σ² + β².

    Args:
        sigma_max: The largest σ.
        threshold: ε.
        damping: λ_max.
        floor: β.
    """
    slope = 1 - (damping / threshold) ** 2
    peak = math.sqrt((damping**2 + floor**2) / slope) if slope > 0 else math.inf
    inside = [peak] if peak < threshold else []
    candidates = np.array([*inside, threshold, max(floor, threshold), sigma_max])
    candidates = candidates[candidates <= sigma_max]
    return float(damped_gain(candidates, fading_damping(candidates, threshold, damping) + floor**2).max())
