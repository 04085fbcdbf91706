"""Exponentially damped least squares: the fraction of the command that is followed decays exponentially."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_measures, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card
from robust_ik.inverses.damping_formulas import Quantity, falling_zero, kept_or_zero
from robust_ik.inverses.gain_formula import GainFormula
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.compiler.where import where
from robust_ik.kinematics.singular_value_gradients import singular_value_gradients
from robust_ik.kinematics.svd import svd


@dataclass(frozen=True)
class EDLS(GainFormula):
    """φ(σ) = d(σ)/σ with d = max(0, 1 − β^((σ − s₋)/(s₊ − s₋))).

    The fraction d of the command is 0 up to s₋, 1 − β at s₊, and tends to 1 above.

    Watch for: with s₋ = 0, φ(0⁺) = −ln β/s₊ (13.04 for the defaults), so the arm chatters at a target out of reach;
    with s₋ > 0 it comes to rest where σ = s₋, off the singularity, and no command along that direction moves it away.
    Printed without the max, d is negative below s₋: the motion is reversed, and grows as 1/σ.

    Attributes:
        beta: β in (0, 1): the fraction that is missing at s₊.
        lower: s₋ ≥ 0, in the units of σ.
        upper: s₊ > s₋, in the units of σ.
        raw: Leaves out the max.
        asymmetric: `velocity` damps only the components of the motion that lower their own σ, and gives the others
            1/max(σ, floor): our reading of damping "towards the singularity". It needs the Hessian, and jumps where a
            component changes sides; `solve`, which has none, damps all.
        floor: Used by `asymmetric` only; > 0, in the units of σ.

    Source: Carmichael, Liu and Waldron 2017.
    """

    source: ClassVar[str] = "Carmichael-Liu-Waldron 2017"
    card: ClassVar[Card] = Card(
        formula="d/σ, 0 at σ = 0; d = max(0, 1 − β^((σ − s₋)/(s₊ − s₋)))",
        largest_gain="−ln β/s₊ for s₋ = 0; 4.397 for s₋ = 0.1",
        gain_at_zero="−ln β/s₊ for s₋ = 0, else 0",
        exact="nowhere; 1 − β at s₊",
        continuity="jumps by −2 ln β/s₊ at σ = 0 for s₋ = 0, else continuous",
    )
    beta: float = 0.02
    lower: float = 0.0
    upper: float = 0.3
    raw: bool = False
    asymmetric: bool = False
    floor: float = 0.01

    def __post_init__(self) -> None:
        checked_parameter("beta", self.beta, above=0, below=1)
        checked_parameter("lower", self.lower, least=0)
        checked_parameter("upper", self.upper)
        if self.lower >= self.upper:
            raise InputError(f"lower must be < upper, got lower={self.lower!r} and upper={self.upper!r}")
        checked_parameter("floor", self.floor, above=0)

    @property
    def needs_hessian(self) -> bool:
        """Whether `asymmetric` is set."""
        return self.asymmetric

    @property
    def _rate(self) -> float:
        """−ln β/(s₊ − s₋), so that d = 1 − e^(−rate (σ − s₋))."""
        return -math.log(self.beta) / (self.upper - self.lower)

    @staticmethod
    def formula(
        s: Quantity, largest: Quantity, smallest: Quantity, product: Quantity, place: Quantity, p: Any
    ) -> Quantity:
        """d(σ)/σ, and 0 at σ = 0."""
        # An exponent ≤ 0 is d ≥ 0; the limit on a raw one only keeps it from overflowing.
        share = -np.expm1(np.minimum(-p[0] * (s - p[1]), p[2]))
        return where(s > 0, share, 0.0) * kept_or_zero(s > 0, s)

    @property
    def parameters(self) -> tuple[float, ...]:
        """−ln β/(s₊ − s₋), s₋ and the largest exponent."""
        return (self._rate, self.lower, 300.0 if self.raw else 0.0)

    def velocity(self, equation: TaskEquation) -> Array:
        """q̇ = Σ φᵢ vᵢ uᵢᵀẋ; if asymmetric with φᵢ = 1/max(σᵢ, floor) unless (∂σᵢ/∂q · vᵢ) uᵢᵀẋ < 0."""
        if not self.asymmetric:
            return super().velocity(equation)
        if equation.hessian is None:
            raise InputError("EDLS(asymmetric=True) needs the equation's Hessian: it looks which way each σ moves")
        decomposition = svd(equation.J)
        s, Vt = decomposition.s, decomposition.Vt
        xdot = as_measures(equation.xdot, "xdot", (decomposition.U.shape[-2],))
        components = np.einsum("...mk,...m->...k", decomposition.U, xdot)
        # If (u, v) is replaced by (−u, −v) the sign stays, so any SVD will do.
        slopes = np.einsum("...kn,...kn->...k", singular_value_gradients(equation.J, equation.hessian), Vt)
        leaving = (s > 0) / np.maximum(s, self.floor)
        gains = np.where(slopes * components < 0, self.gains_of(s), leaving)
        return np.asarray(np.einsum("...kn,...k->...n", Vt, gains * components))

    def largest_gain(self, sigma_max: float) -> float:
        """−ln β/s₊ for s₋ = 0; else φ at its only peak, or at σ₁ below that; infinite if raw and s₋ > 0.

        If asymmetric, at least 1/floor: it bounds `velocity` too.
        """
        if sigma_max <= 0:
            return 0.0
        if self.lower == 0:
            largest = self._rate
        elif self.raw:
            largest = math.inf
        else:
            largest = float(self.gains(min(sigma_max, self._peak())))
        return max(largest, 1 / self.floor) if self.asymmetric else largest

    def _peak(self) -> float:
        """σ = y/rate with y − ln(1 + y) = rate s₋, from φ′ = 0; 0.176 for β = 0.02, s₋ = 0.1, s₊ = 0.3."""
        level = self._rate * self.lower
        return falling_zero(lambda y: level - y + math.log1p(y), 0.0, level + math.sqrt(2 * level)) / self._rate

    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """No direction."""
        return np.zeros(np.shape(s), dtype=bool)

    def gain_at_zero(self, sigma_max: float) -> float:
        """−ln β/s₊ for s₋ = 0, else 0; −∞ if raw and s₋ > 0."""
        if sigma_max <= 0:
            return 0.0
        if self.lower == 0:
            return self._rate
        return -math.inf if self.raw else 0.0

    @property
    def continuous(self) -> bool:
        """Whether s₋ > 0, and neither `raw` nor `asymmetric` is set."""
        return super().continuous and not self.asymmetric
