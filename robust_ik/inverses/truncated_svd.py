"""The truncated SVD: drops directions that are almost lost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array
from robust_ik.inverses.base import Card, Jump
from robust_ik.inverses.damping_formulas import Quantity, check_level, kept_or_zero
from robust_ik.inverses.gain_formula import GainFormula


@dataclass(frozen=True)
class TruncatedSVD(GainFormula):
    """φ(σ) = 1/σ where σ > τ, else 0.

    With `gamma` this is J-PARSE's ablation JacobianProjection, and JacobianSafetyProjection too: see `ablations`.

    Watch for: joint speeds jump by 1/τ where a σ crosses τ, and what is dropped is not followed at all: an arm that
    has come within τ of a singularity gets no command to leave it along the lost direction.

    Attributes:
        threshold: τ > 0 in the units of σ; or
        gamma: τ as the fraction γ in (0, 1) of σ₁. Without either: γ = 0.1.

    Source: Hansen 1987; J-PARSE 2025, eq. (57) and (59).
    """

    source: ClassVar[str] = "Hansen 1987; J-PARSE 2025, eq. (57), (59)"
    card: ClassVar[Card] = Card(
        formula="1/σ where σ > τ, else 0; τ absolute or γσ₁",
        largest_gain="1/τ",
        gain_at_zero="0",
        exact="σ > τ",
        continuity="jumps by 1/τ at τ",
    )
    threshold: float | None = None
    gamma: float | None = None

    def __post_init__(self) -> None:
        if self.threshold is None and self.gamma is None:
            object.__setattr__(self, "gamma", 0.1)
        check_level("threshold", self.threshold, self.gamma)

    def level(self, sigma_max: ArrayLike) -> Array:
        """τ for σ₁ = sigma_max, in its shape."""
        sigma_max = np.asarray(sigma_max, dtype=float)
        return np.asarray(np.full_like(sigma_max, self.threshold) if self.gamma is None else self.gamma * sigma_max)

    @property
    def relative(self) -> bool:
        """Whether a threshold relative to σ₁ is used."""
        return self.gamma is not None

    @staticmethod
    def formula(
        s: Quantity, largest: Quantity, smallest: Quantity, product: Quantity, place: Quantity, p: Any
    ) -> Quantity:
        """1/σ above τ, else 0."""
        return kept_or_zero(s > p[0] + p[1] * largest, s)

    @property
    def parameters(self) -> tuple[float, ...]:
        """τ as such and as a fraction of σ₁; one of them is 0."""
        return (self.threshold or 0.0, self.gamma or 0.0)

    def largest_gain(self, sigma_max: float) -> float:
        """1/τ, approached just above the threshold; 0 if σ₁ ≤ τ."""
        level = float(self.level(sigma_max))
        return 1 / level if sigma_max > level else 0.0

    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """Directions with σ > τ."""
        s = np.asarray(s, dtype=float)
        return np.asarray(s > self.level(s[..., :1]))

    def jumps(self, sigma_max: float) -> tuple[Jump, ...]:
        """1/τ at τ, if τ < σ₁."""
        level = float(self.level(sigma_max))
        return (Jump(level, 1 / level),) if sigma_max > level else ()
