"""ESRIM: the damping of each direction grows from zero as its singular value falls below a threshold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal, get_args

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_parameter
from robust_ik.checks.public_arguments import check_type
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card
from robust_ik.inverses.damping_formulas import Quantity, damped
from robust_ik.inverses.gain_formula import GainFormula

BetaRule = Literal["floor", "linear", "chiaverini"]
AlphaMode = Literal["scalar", "singular"]


@dataclass(frozen=True)
class ESRIM(GainFormula):
    """φ(σ) = ασ/(α²σ² + β²(σ)): minimises ‖ẋ − αJ q̇‖² + ‖B q̇‖² where B has the singular values β(σ), 0 above σ₀.

    The rules for β, with x = σ/σ₀ < 1, and the largest gain that they give for α = 1:

    * "floor": β² = σ₀² (1 − x²), so φ = σ/σ₀²: 1/σ₀. It is J-PARSE with an absolute threshold.
    * "linear": β = σ₀ (1 − x): 1.2071/σ₀, at x = 1/√2.
    * "chiaverini": β² = λ² (1 − x²).

    Watch for: the formulas of the source are lost; these are reconstructed from its text. With `alpha_mode="scalar"`
    and α₀ ≠ 1 nothing is exact: each step goes 1/α₀ of the way, in regular directions too. "singular" blends
    α = 1 + (α₀ − 1)(1 − x²), since a hard switch at σ₀ would jump from 1/σ₀ to 1/(α₀σ₀). σ₀ = 1.3 of the source is
    in mm; in metres it would damp every direction.

    Attributes:
        sigma0: σ₀ > 0, "the smallest singular value allowed", in the units of σ.
        alpha0: α₀ > 0, the factor on the Jacobian.
        beta_rule: "floor", "linear" or "chiaverini".
        alpha_mode: "scalar": α = α₀ everywhere; "singular": only below σ₀.
        damping: λ > 0 of the rule "chiaverini", in the units of σ; None with any other.

    Source: ESRIM 2020, eq. (15) to (21) and (29).
    """

    source: ClassVar[str] = "ESRIM 2020, eq. (15)-(21), (29)"
    card: ClassVar[Card] = Card(
        formula="ασ/(α²σ² + β²(σ)), β = 0 from σ₀ on",
        largest_gain="by the rule; α = 1: 1/σ₀ (floor), 1.2071/σ₀ (linear)",
        gain_at_zero="0",
        exact="σ ≥ σ₀ where α = 1 there",
        continuity="continuous",
    )
    sigma0: float = 0.1
    alpha0: float = 1.0
    beta_rule: BetaRule = "floor"
    alpha_mode: AlphaMode = "scalar"
    damping: float | None = None

    def __post_init__(self) -> None:
        check_type("beta_rule", self.beta_rule, "str")
        check_type("alpha_mode", self.alpha_mode, "str")
        checked_parameter("sigma0", self.sigma0, above=0)
        checked_parameter("alpha0", self.alpha0, above=0)
        for name, choices in (("beta_rule", get_args(BetaRule)), ("alpha_mode", get_args(AlphaMode))):
            if getattr(self, name) not in choices:
                raise InputError(f"{name} must be one of {', '.join(choices)}, got {getattr(self, name)!r}")
        if self.beta_rule == "chiaverini":
            checked_parameter("damping", self.damping, above=0)
        elif self.damping is not None:
            raise InputError(f'damping goes with beta_rule="chiaverini" only, got {self.damping!r}')

    @property
    def _factor(self) -> tuple[float, float]:
        """Arguments of `factor`: for α = α₀ everywhere, or for α = 1 at σ₀ and α₀ at 0."""
        return (self.alpha0, 0.0) if self.alpha_mode == "scalar" else (1.0, self.alpha0 - 1)

    @property
    def _damping(self) -> tuple[float, float]:
        """Arguments of `relative_damping`."""
        if self.damping is not None:
            return 0.0, (self.damping / self.sigma0) ** 2
        return (1.0, 0.0) if self.beta_rule == "linear" else (0.0, 1.0)

    @staticmethod
    def formula(
        s: Quantity, largest: Quantity, smallest: Quantity, product: Quantity, place: Quantity, p: Any
    ) -> Quantity:
        """ασ/(α²σ² + β²)."""
        x = np.minimum(s, p[0]) / p[0]
        return damped(factor(x, p[1], p[2]) * s, p[0] ** 2 * relative_damping(x, p[3], p[4]))

    @property
    def parameters(self) -> tuple[float, ...]:
        """σ₀, then the arguments of `factor` and of `relative_damping`."""
        return (self.sigma0, *self._factor, *self._damping)

    def largest_gain(self, sigma_max: float) -> float:
        """φ at its largest peak: inside (0, σ₀), at σ₀, or at σ₁ if that is smaller."""
        candidates = np.array([*self._peaks(), self.sigma0, sigma_max])
        return float(self.gains(candidates[candidates <= sigma_max]).max())

    def _peaks(self) -> Array:
        """Every σ < σ₀ with φ′ = 0: σ₀φ = αx/(α²x² + β²/σ₀²) is a ratio of polynomials."""
        x = Polynomial([0.0, 1.0])
        above = factor(x, *self._factor) * x
        below = above**2 + relative_damping(x, *self._damping)
        roots = np.real((above.deriv() * below - above * below.deriv()).trim(1e-14).roots())
        # The real part of a complex root is no peak, but harmless as a candidate.
        return np.asarray(self.sigma0 * roots[(roots > 0) & (roots < 1)])

    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """Directions with σ ≥ σ₀, if α = 1 there."""
        s = np.asarray(s, dtype=float)
        return np.asarray((s >= self.sigma0) & (self.alpha0 == 1 or self.alpha_mode == "singular"))


# Both take x = σ/σ₀ ≤ 1: a number, an array, or the polynomial x.
def factor(x: Quantity, constant: Quantity, added: Quantity) -> Quantity:
    """α as a function of x."""
    return constant + added * (1.0 - x**2)


def relative_damping(x: Quantity, linear: Quantity, floor: Quantity) -> Quantity:
    """β²/σ₀² as a function of x."""
    return linear * (1.0 - x) ** 2 + floor * (1.0 - x**2)
