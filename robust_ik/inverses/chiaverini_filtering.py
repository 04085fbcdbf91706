"""Numerical filtering: damps only the directions that are almost lost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_parameter
from robust_ik.checks.public_arguments import check_type
from robust_ik.inverses.base import Card, Jump
from robust_ik.inverses.chiaverini import largest_fading_gain
from robust_ik.inverses.damping_formulas import Quantity, damped, damped_gain, fading, fading_damping
from robust_ik.inverses.gain_formula import GainFormula
from robust_ik.kernels.compiler.where import where


@dataclass(frozen=True)
class ChiaveriniFiltering(GainFormula):
    """φᵢ = σᵢ/(σᵢ² + β² + λ²(σᵢ)), λ² = (1 − (σ/ε)²) λ_max² below ε: for every σᵢ < ε, or for the last one only.

    `multi=True`, the default, damps each singular value by itself: continuous, bounded, exact above ε. The printed
    form, `multi=False, floor=0`, damps the last direction only: Jᵀ (J Jᵀ + λ² u_k u_kᵀ)⁻¹.

    Watch for: with `multi=False` the damping jumps from one direction to another where the two smallest singular
    values cross below ε, and joint speeds jump (by 13.1 s⁻¹ per unit at σ = 0.04 with the defaults and no floor);
    the second smallest is undamped, so without a floor speeds are unbounded where two directions are lost together.

    Attributes:
        threshold: ε > 0, the σ above which λ is 0, in the units of σ.
        damping: λ_max > 0, in the units of σ.
        floor: β ≥ 0, a small damping in all directions, always; it bounds speeds by 1/(2β) and costs exactness.
            Default: 0 with `multi`, which needs none, else 0.005.
        multi: Whether every σᵢ < ε is damped by its own λ(σᵢ), rather than the last one only.

    Source: Maciejewski and Klein 1988; Chiaverini 1997, eq. (20); Kim, Marani, Chung and Yuh, eq. (31) and (32).
    """

    source: ClassVar[str] = "Maciejewski-Klein 1988, Chiaverini 1997"
    card: ClassVar[Card] = Card(
        formula="σ/(σ² + β² + λ²(σ)), λ² = (1 − (σ/ε)²)λ_max² below ε; or with λ for the last σ only",
        largest_gain="1/ε for λ_max ≥ ε/√2, β = 0; last σ only: 1/(2β)",
        gain_at_zero="0; last σ only: the next one's grows to 1/(2β)",
        exact="σ ≥ ε where β = 0",
        continuity="continuous; last σ only: jumps where the last two cross below ε",
    )
    threshold: float = 0.05
    damping: float = 0.07
    floor: float | None = None
    multi: bool = True

    def __post_init__(self) -> None:
        check_type("multi", self.multi, "bool")
        checked_parameter("threshold", self.threshold, above=0)
        checked_parameter("damping", self.damping, above=0)
        if self.floor is None:
            object.__setattr__(self, "floor", 0.0 if self.multi else 0.005)
        checked_parameter("floor", self.floor, least=0)

    def _squared_damping(self, s: Array) -> Array:
        fading = fading_damping(s, self.threshold, self.damping)
        if not self.multi:
            fading[..., :-1] = 0.0
        return np.asarray(fading + self._beta**2)

    @property
    def _beta(self) -> float:
        return self.floor or 0.0

    @staticmethod
    def formula(
        s: Quantity, largest: Quantity, smallest: Quantity, product: Quantity, place: Quantity, p: Any
    ) -> Quantity:
        """σ/(σ² + β² + λ²), where λ depends on σ itself; for `multi=False` λ = 0 except for the last one."""
        own = where((p[3] > 0) | (place == 0), fading(s, p[0], p[1]), 0.0)
        return damped(s, own + p[2] ** 2)

    @property
    def parameters(self) -> tuple[float, ...]:
        """ε, λ_max, β and `multi`."""
        return (self.threshold, self.damping, self._beta, float(self.multi))

    def largest_gain(self, sigma_max: float) -> float:
        """As for `Chiaverini` with β² added; without `multi` 1/(2β), infinite for β = 0: two may be lost together."""
        if self.multi:
            return largest_fading_gain(sigma_max, self.threshold, self.damping, self._beta)
        if sigma_max < self._beta or sigma_max <= 0:
            return float(damped_gain(sigma_max, self._beta**2))
        return 1 / (2 * self._beta) if self._beta > 0 else math.inf

    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """Directions where nothing is added to σ²; none with a floor."""
        s = np.asarray(s, dtype=float)
        return np.asarray((self._squared_damping(s) == 0) & (s > 0))

    def jumps(self, sigma_max: float, others: Sequence[float] = ()) -> tuple[Jump, ...]:
        """None with `multi`; else one where the varying singular value becomes the last one, if that is below ε.

        Args:
            sigma_max: σ₁, which is fixed.
            others: Further fixed singular values, at most σ₁; without them the varying one is always the last.
        """
        crossing = min([*as_array(others, "others", (None,)).ravel().tolist(), sigma_max])
        if self.multi or crossing >= min(self.threshold, sigma_max):
            return ()
        second, last = self.gains([crossing, crossing])
        return (Jump(crossing, float(second - last)),)

    @property
    def continuous(self) -> bool:
        """Whether `multi` is set."""
        return self.multi
