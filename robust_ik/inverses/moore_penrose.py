"""The pseudo-inverse: exact wherever possible, unbounded near a singularity."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import checked_parameter
from robust_ik.inverses.base import Card, Jump
from robust_ik.inverses.damping_formulas import Quantity, kept_or_zero
from robust_ik.inverses.gain_formula import GainFormula
from robust_ik.kinematics.svd import RANK_TOLERANCE


@dataclass(frozen=True)
class MoorePenrose(GainFormula):
    """φ(σ) = 1/σ, and 0 where σ ≤ tolerance · σ₁.

    Watch for: joint speeds grow as 1/σ without bound, and drop to zero at the tolerance.

    Attributes:
        tolerance: What counts as σ = 0, relative to the largest singular value.

    Source: Whitney 1969; SGIM in ESRIM (2020), eq. (7) to (9).
    """

    source: ClassVar[str] = "Whitney 1969"
    card: ClassVar[Card] = Card(
        formula="1/σ; 0 where σ ≤ tolerance·σ₁",
        largest_gain="1/(tolerance·σ₁)",
        gain_at_zero="0",
        exact="σ > tolerance·σ₁",
        continuity="jumps at tolerance·σ₁",
    )
    tolerance: float = RANK_TOLERANCE

    def __post_init__(self) -> None:
        checked_parameter("tolerance", self.tolerance, above=0, below=1)

    @property
    def relative(self) -> bool:
        """Yes."""
        return True

    @staticmethod
    def formula(
        s: Quantity, largest: Quantity, smallest: Quantity, product: Quantity, place: Quantity, p: Any
    ) -> Quantity:
        """1/σ above the tolerance, else 0."""
        return kept_or_zero(s > p[0] * largest, s)

    @property
    def parameters(self) -> tuple[float, ...]:
        """The tolerance."""
        return (self.tolerance,)

    def largest_gain(self, sigma_max: float) -> float:
        """1/(tolerance · σ₁): no useful bound."""
        least = self.tolerance * sigma_max
        return 1 / least if least > 0 else math.inf if sigma_max > 0 else 0.0

    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """Directions whose σ counts as non-zero."""
        s = np.asarray(s, dtype=float)
        return np.asarray(s > self.tolerance * s[..., :1])

    def jumps(self, sigma_max: float) -> tuple[Jump, ...]:
        """A jump from 1/(tolerance · σ₁) to 0 at the tolerance."""
        return (Jump(self.tolerance * sigma_max, self.largest_gain(sigma_max)),)
