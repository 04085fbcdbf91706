"""Duleba's clamp: small singular values are raised to a floor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, Jump
from robust_ik.inverses.damping_formulas import Quantity, check_level, kept_or_zero
from robust_ik.inverses.gain_formula import GainFormula
from robust_ik.kernels.compiler.where import where


@dataclass(frozen=True)
class DulebaClamp(GainFormula):
    """φ(σ) = 1/max(σ, d_min) for σ > 0, and φ(0) = 0: at σ = 0 itself the signs of u and v are arbitrary.

    With `gamma` this is J-PARSE's ablation JacobianSafety: see `ablations`.

    Watch for: φ(0⁺) = 1/d_min, not 0. A command along a lost direction turns the joints at ‖ẋ‖/d_min with the
    arbitrary sign of (u, v), which flips as the arm crosses the singularity: it chatters there. The experiment of the
    source acts on σ < 10⁻³ and raises it to 10⁻²: with `detect` < `floor` the speed also jumps from 1/detect to
    1/floor.

    Attributes:
        floor: d_min > 0 in the units of σ; default 0.01 without `gamma`.
        detect: Only σ < detect ≤ floor is raised; default the floor itself.
        gamma: Instead of both: d_min as the fraction γ in (0, 1) of σ₁.

    Source: Duleba 2023, eq. (22), bound (41); J-PARSE 2025, eq. (20) and (58).
    """

    source: ClassVar[str] = "Duleba 2023, eq. (22); J-PARSE 2025, eq. (58)"
    card: ClassVar[Card] = Card(
        formula="1/max(σ, d_min), 0 at σ = 0; d_min absolute or γσ₁",
        largest_gain="1/d_min; 1/detect where detect < d_min",
        gain_at_zero="1/d_min",
        exact="σ ≥ d_min; σ ≥ detect",
        continuity="jumps by 2/d_min at σ = 0; by 1/detect − 1/d_min at detect",
    )
    floor: float | None = None
    detect: float | None = None
    gamma: float | None = None

    def __post_init__(self) -> None:
        if self.floor is None and self.gamma is None:
            object.__setattr__(self, "floor", 1e-2)
        check_level("floor", self.floor, self.gamma)
        if self.floor is None:
            if self.detect is not None:
                raise InputError(f"detect goes with floor, not with gamma: got detect={self.detect!r}")
            return
        if self.detect is None:
            object.__setattr__(self, "detect", self.floor)
        if checked_parameter("detect", self.detect, above=0) > self.floor:
            raise InputError(f"detect must be ≤ floor, got detect={self.detect!r} and floor={self.floor!r}")

    def levels(self, sigma_max: ArrayLike) -> tuple[Array, Array]:
        """The σ below which σ is raised, and the value to which it is raised, for σ₁ = sigma_max, in its shape."""
        sigma_max = np.asarray(sigma_max, dtype=float)
        if self.gamma is not None:
            return self.gamma * sigma_max, self.gamma * sigma_max
        return np.full_like(sigma_max, self.detect), np.full_like(sigma_max, self.floor)

    @property
    def relative(self) -> bool:
        """Whether `gamma` is given."""
        return self.gamma is not None

    @staticmethod
    def formula(
        s: Quantity, largest: Quantity, smallest: Quantity, product: Quantity, place: Quantity, p: Any
    ) -> Quantity:
        """1/max(σ, d_min), and 0 at σ = 0."""
        raised = where(s >= p[0] + p[2] * largest, s, p[1] + p[2] * largest)
        return kept_or_zero(s > 0, raised)

    @property
    def parameters(self) -> tuple[float, ...]:
        """`detect` and d_min, in the units of σ or as fractions of σ₁."""
        return (self.detect or 0.0, self.floor or 0.0, self.gamma or 0.0)

    def largest_gain(self, sigma_max: float) -> float:
        """1/d_min; 1/detect, reached at σ = detect, where σ₁ ≥ detect."""
        if sigma_max <= 0:
            return 0.0
        detect, floor = self.levels(sigma_max)
        return float(1 / detect if sigma_max >= detect else 1 / floor)

    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """Directions where σ is not raised."""
        s = np.asarray(s, dtype=float)
        return np.asarray((s >= self.levels(s[..., :1])[0]) & (s > 0))

    def gain_at_zero(self, sigma_max: float) -> float:
        """1/d_min."""
        return float(1 / self.levels(sigma_max)[1]) if sigma_max > 0 else 0.0

    def jumps(self, sigma_max: float) -> tuple[Jump, ...]:
        """2/d_min at σ = 0; for detect < d_min also 1/detect − 1/d_min at detect."""
        detect, floor = (float(level) for level in self.levels(sigma_max))
        at_detect = (Jump(detect, 1 / detect - 1 / floor),) if detect < min(floor, sigma_max) else ()
        return super().jumps(sigma_max) + at_detect
