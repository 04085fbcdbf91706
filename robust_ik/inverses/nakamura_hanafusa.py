"""Nakamura and Hanafusa's damped least squares: damping grows as the manipulability vanishes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_parameter
from robust_ik.inverses.base import LARGE_SIGMA, Card
from robust_ik.inverses.damping_formulas import Quantity, damped, falling_zero
from robust_ik.inverses.gain_formula import GainFormula
from robust_ik.kernels.compiler.where import where


@dataclass(frozen=True)
class NakamuraHanafusa(GainFormula):
    """φᵢ = σᵢ/(σᵢ² + λ²(w)) with λ = λ₀ (1 − w/w₀)² below the manipulability w₀ and 0 above, w = Π σ.

    Watch for: w mixes all directions and their units. The damping can begin while every σ is large, and stay off
    at a small σ if the others are large: then φ is as large as σ₁^(k−1)/w₀, for k singular values.

    Attributes:
        damping: λ₀ > 0 in the units of σ.
        manipulability_threshold: w₀ > 0, in the units of Π σ.
        squared: Whether λ is squared in the matrix, as everywhere here. False: k₀ (1 − w/w₀)² with k₀ = λ₀ is added
            as it is, as in the original and in J-PARSE's planar example; at w = 0, k₀ stands for λ₀².

    Source: Nakamura and Hanafusa 1986.
    """

    source: ClassVar[str] = "Nakamura-Hanafusa 1986"
    card: ClassVar[Card] = Card(
        formula="σ/(σ² + λ²(w)), λ = λ₀(1 − w/w₀)² below w₀, w = Π σ",
        largest_gain="grows with σ₁ and k: at least σ₁^(k−1)/w₀ for σ₁^k ≥ w₀",
        gain_at_zero="0",
        exact="all directions where w ≥ w₀",
        continuity="continuous",
    )
    damping: float = 0.1
    manipulability_threshold: float = 0.02
    squared: bool = True

    def __post_init__(self) -> None:
        checked_parameter("damping", self.damping, above=0)
        checked_parameter("manipulability_threshold", self.manipulability_threshold, above=0)

    def squared_damping(self, s: ArrayLike) -> Array:
        """The term added to σ², for a whole spectrum (..., k): shape (...)."""
        ratio = np.minimum(self._manipulability(s) / self.manipulability_threshold, 1.0)
        return np.asarray(added(ratio, self.damping, float(self.squared)))

    def _manipulability(self, s: ArrayLike) -> Array:
        s = np.asarray(s, dtype=float)
        with np.errstate(over="ignore", invalid="ignore"):  # beyond any threshold; 0 · ∞ is overruled below
            return np.where(s[..., -1] > 0, np.prod(s, axis=-1), 0.0)

    @staticmethod
    def formula(
        s: Quantity, largest: Quantity, smallest: Quantity, product: Quantity, place: Quantity, p: Any
    ) -> Quantity:
        """σ/(σ² + λ²(w))."""
        ratio = np.minimum(product, p[1]) / p[1]  # in this order, since w/w₀ may overflow
        return damped(s, added(ratio, p[0], p[2]))

    @property
    def parameters(self) -> tuple[float, ...]:
        """λ₀, w₀ and whether λ is squared."""
        return (self.damping, self.manipulability_threshold, float(self.squared))

    def largest_gain(self, sigma_max: float, count: int | None = None) -> float:
        """The least upper bound over all spectra with that many singular values.

        For σ₁ > 1 it grows with their number without bound, since so does w at any σ.

        Args:
            sigma_max: σ₁.
            count: k = min(m, n); None stands for any.
        """
        if count is not None:
            checked_parameter("count", count, least=1)
        if sigma_max <= 0:
            return 0.0
        if count == 1:
            return float(self.gains([sigma_max])[0])
        if count is not None:
            return self._largest_of_several(sigma_max, count)
        if sigma_max > 1:
            return math.inf
        return max(self.largest_gain(sigma_max, 1), self._largest_of_several(sigma_max, 2))

    def _largest_of_several(self, sigma_max: float, count: int) -> float:
        """The largest φ(σ) if all others are σ₁: then w, and with it φ, is as large as possible at that σ."""
        with np.errstate(over="ignore"):
            undamped = float(self.manipulability_threshold * np.float64(sigma_max) ** (1 - count))
        if undamped == 0:
            return math.inf
        undamped = min(undamped, LARGE_SIGMA)
        candidates = [undamped * self._peak(undamped), sigma_max]
        others = [sigma_max] * (count - 1)
        found = [float(self.gains([*others, sigma])[-1]) for sigma in candidates if sigma <= sigma_max]
        # At w₀ itself nothing is added; evaluated there, w would be rounded.
        return max(found + ([1 / undamped] if undamped <= sigma_max else []))

    def _peak(self, undamped: float) -> float:
        """The maximum in (0, 1) of x/(a² x² + k(x)), where x is w/w₀ and a the σ above which there is no damping."""
        if not self.squared:
            return 1 / math.sqrt(1 + undamped**2 / self.damping)
        weight = (undamped / self.damping) ** 2
        return falling_zero(lambda x: (1 - x) ** 3 * (1 + 3 * x) - weight * x**2, 0.0, 1.0)

    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """All directions if w ≥ w₀, else none."""
        exact = self._manipulability(s) >= self.manipulability_threshold
        return np.array(np.broadcast_to(exact[..., None], np.shape(s)))


def added(ratio: Quantity, damping: Quantity, squared: Quantity) -> Quantity:
    """The term added to σ², where `ratio` is w/w₀, at most 1."""
    fallen = damping * (1.0 - ratio) ** 2
    return where(squared > 0, fallen**2, fallen)
