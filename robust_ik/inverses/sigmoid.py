"""Sigmoid damping: each singular value is damped by itself, with a damping that fades smoothly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card
from robust_ik.inverses.damping_formulas import Quantity, damped, falling_zero
from robust_ik.inverses.gain_formula import GainFormula

STEEPEST = 600.0
"""Largest shift/slope: beyond it e^(−w/h) underflows."""


@dataclass(frozen=True)
class Sigmoid(GainFormula):
    """φ(σ) = σ/(σ² + Λ/(1 + e^((σ + w)/h))).

    Watch for: Λ is *added as it is*: it is the square of what other inverses call damping, and about half of it acts
    at σ = 0. The damping fades as e^(−σ/h) and is never quite 0.

    Attributes:
        squared_damping: Λ > 0, in the units of σ².
        shift: w ≥ 0, in the units of σ: the larger, the less damping.
        slope: h > 0, in the units of σ: the increase of σ over which the damping falls by the factor e.

    Source: Fraunhofer IPA, cob_twist_controller 2015, damping method "sigmoid".
    """

    source: ClassVar[str] = "Fraunhofer IPA, cob_twist_controller 2015"
    card: ClassVar[Card] = Card(
        formula="σ/(σ² + Λ/(1 + e^((σ + w)/h)))",
        largest_gain="no closed form; 25.26 for the defaults",
        gain_at_zero="0",
        exact="nowhere",
        continuity="continuous",
    )
    squared_damping: float = 0.001
    shift: float = 0.001
    slope: float = 0.05

    def __post_init__(self) -> None:
        checked_parameter("squared_damping", self.squared_damping, above=0)
        checked_parameter("shift", self.shift, least=0)
        checked_parameter("slope", self.slope, above=0)
        if self.shift > STEEPEST * self.slope:
            raise InputError(
                f"shift must be at most {STEEPEST:g} times slope, else nothing is damped, "
                f"got {self.shift!r} and {self.slope!r}"
            )

    @staticmethod
    def formula(
        s: Quantity, largest: Quantity, smallest: Quantity, product: Quantity, place: Quantity, p: Any
    ) -> Quantity:
        """σ/(σ² + Λ/(1 + e^((σ + w)/h)))."""
        return damped(s, added(s, p[0], p[1], p[2]))

    @property
    def parameters(self) -> tuple[float, ...]:
        """Λ, w, h."""
        return (self.squared_damping, self.shift, self.slope)

    def largest_gain(self, sigma_max: float) -> float:
        """φ at its only peak, or at σ₁ if that is smaller."""
        return float(self.gains(min(sigma_max, self._peak())))

    def _peak(self) -> float:
        """The peak, where k − σk′ = σ² for k added to σ²; the difference falls, since k is convex for w ≥ 0."""

        def difference(sigma: float) -> float:
            k = float(added(sigma, *self.parameters))
            rate = k * (1 - k / self.squared_damping) / self.slope
            return k + sigma * rate - sigma**2

        return falling_zero(difference, 0.0, math.sqrt(self.squared_damping))

    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """No direction."""
        return np.zeros(np.shape(s), dtype=bool)


def added(s: Quantity, squared_damping: Quantity, shift: Quantity, slope: Quantity) -> Quantity:
    """The term added to σ²: Λ/(1 + eᶻ), without overflow."""
    return squared_damping * np.exp(-np.logaddexp(0.0, (s + shift) / slope))
