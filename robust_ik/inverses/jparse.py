"""J-PARSE: exact away from singularities, and slower and slower along the directions that vanish."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_parameter
from robust_ik.inverses.base import Card, Jump, SingularValueFilter


@dataclass(frozen=True)
class JParse(SingularValueFilter):
    """φ(σ) = 1/σ where σ > γσ₁, else p σ/(γσ₁)².

    Along a direction whose singular value falls below γσ₁ the command is projected out and fed back with the gain
    p σ/(γσ₁): the joint speed falls with σ, a singularity can be reached, and left again.

    Watch for: γ is relative, and σ₁ moves with q; p ≠ 1 makes φ jump by the factor p at the threshold. The seed
    divides by γ where its text only says "ratio": without it φ would drop by the factor γ there.

    Attributes:
        gamma: Threshold γ in (0, 1), relative to the largest singular value.
        gain: p > 0, the speed along singular directions; 1 is the continuous choice.

    Source: J-PARSE, eq. (19) to (31).
    """

    source: ClassVar[str] = "J-PARSE 2025, eq. (19)-(31)"
    card: ClassVar[Card] = Card(
        formula="1/σ where σ > γσ₁, else p σ/(γσ₁)²",
        largest_gain="max(1, p)/(γσ₁)",
        gain_at_zero="0",
        exact="σ > γσ₁",
        continuity="continuous for p = 1, else jumps at γσ₁",
    )
    gamma: float = 0.1
    gain: float = 1.0

    def __post_init__(self) -> None:
        checked_parameter("gamma", self.gamma, above=0, below=1)
        checked_parameter("gain", self.gain, above=0)

    def gains(self, s: ArrayLike) -> Array:
        """1/σ above γσ₁, p σ/(γσ₁)² below."""
        s = np.asarray(s, dtype=float)
        threshold = np.where(s[..., :1] > 0, self.gamma * s[..., :1], 1.0)
        # Dividing twice keeps a tiny threshold from underflowing when squared.
        return np.asarray(
            np.where(self.is_exact(s), 1.0, self.gain) * s / np.maximum(s, threshold) / np.maximum(s, threshold)
        )

    def largest_gain(self, sigma_max: float) -> float:
        """max(1, p)/(γσ₁), reached at the threshold."""
        return max(1.0, self.gain) / (self.gamma * sigma_max) if sigma_max > 0 else 0.0

    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """Wherever σ > γσ₁."""
        s = np.asarray(s, dtype=float)
        return np.asarray(s > self.gamma * s[..., :1])

    def jumps(self, sigma_max: float) -> tuple[Jump, ...]:
        """|p − 1|/(γσ₁) at the threshold; none for p = 1."""
        if self.gain == 1 or sigma_max <= 0:
            return ()
        threshold = self.gamma * sigma_max
        return (Jump(threshold, abs(self.gain - 1) / threshold),)
