"""Damped least squares: trades accuracy for bounded joint speed, everywhere alike."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import checked_parameter
from robust_ik.inverses.base import Card
from robust_ik.inverses.damping_formulas import Quantity
from robust_ik.inverses.gain_formula import GainFormula


@dataclass(frozen=True)
class DampedLeastSquares(GainFormula):
    """φ(σ) = σ/(σ² + λ²): minimises ‖J q̇ − ẋ‖² + λ² ‖q̇‖².

    Watch for: nowhere exact; along each direction the fraction σ²/(σ² + λ²) of ẋ is followed, even far from
    singularities.

    Attributes:
        damping: λ > 0, in the units of σ.
        squared: Whether λ is squared in the matrix, as everywhere here. False: λ itself is added to J Jᵀ, as in
            J-PARSE's planar example; it then stands for λ², in the units of σ².

    Source: Nakamura and Hanafusa 1986; Wampler 1986; SRIM in ESRIM (2020); J-PARSE, eq. (56).
    """

    source: ClassVar[str] = "Nakamura-Hanafusa 1986, Wampler 1986"
    card: ClassVar[Card] = Card(
        formula="σ/(σ² + λ²)",
        largest_gain="1/(2λ)",
        gain_at_zero="0",
        exact="nowhere",
        continuity="continuous",
    )
    damping: float = 0.05
    squared: bool = True

    def __post_init__(self) -> None:
        checked_parameter("damping", self.damping, above=0)

    @staticmethod
    def formula(
        s: Quantity, largest: Quantity, smallest: Quantity, product: Quantity, place: Quantity, p: Any
    ) -> Quantity:
        """σ/(σ² + λ²)."""
        return s / (s**2 + p[0] ** 2)

    @property
    def parameters(self) -> tuple[float, ...]:
        """λ."""
        return (self._root,)

    @property
    def squared_damping(self) -> float:
        """λ²."""
        return self.damping**2 if self.squared else self.damping

    @property
    def _root(self) -> float:
        """λ, from the squared damping."""
        return self.damping if self.squared else math.sqrt(self.damping)

    def largest_gain(self, sigma_max: float) -> float:
        """1/(2λ), reached at σ = λ; φ(σ₁) while σ₁ < λ."""
        return 1 / (2 * self._root) if sigma_max >= self._root else float(self.gains(sigma_max))

    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """No direction."""
        return np.zeros(np.shape(s), dtype=bool)
