"""J-PARSE: exact away from singularities, and ever slower along directions that are being lost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, Jump
from robust_ik.inverses.damping_formulas import Quantity
from robust_ik.inverses.gain_formula import GainFormula
from robust_ik.kernels.compiler.where import where


@dataclass(frozen=True)
class JParse(GainFormula):
    """φ(σ) = 1/σ where σ > γσ₁, else p (σ/(γσ₁))^(1/e)/(γσ₁), which is p σ/(γσ₁)² for e = 1.

    Along a direction whose singular value falls below γσ₁ the command is projected out and fed back with the gain
    p σ/(γσ₁): the joint speed falls with σ; the arm can reach a singularity and leave it again.

    Watch for: γ is relative, and σ₁ moves with q; p ≠ 1 makes φ jump by the factor p at the threshold; e > 1 makes φ
    rise from 0 with infinite slope, so that no control step is short enough against chatter at a target out of reach.
    The words around eq. (26) speak of a ratio to σ₁, not to γσ₁; but then φ would drop by the factor γ at the
    threshold, and gain 1 would not be the continuous choice that the paper says it is.

    Attributes:
        gamma: Threshold γ in (0, 1), relative to the largest singular value.
        gain: p > 0, the speed along singular directions; 1 is the continuous choice.
        exponent: e > 0; 1 is J-PARSE, 2 its square-root variant.

    Source: J-PARSE 2025, eq. (19) to (31).
    """

    source: ClassVar[str] = "J-PARSE 2025, eq. (19)-(31)"
    card: ClassVar[Card] = Card(
        formula="1/σ where σ > γσ₁, else p (σ/(γσ₁))^(1/e)/(γσ₁); e = 1",
        largest_gain="max(1, p)/(γσ₁)",
        gain_at_zero="0",
        exact="σ > γσ₁",
        continuity="continuous for p = 1, else jumps at γσ₁",
    )
    gamma: float = 0.1
    gain: float = 1.0
    exponent: float = 1.0

    def __post_init__(self) -> None:
        checked_parameter("gamma", self.gamma, above=0, below=1)
        checked_parameter("gain", self.gain, above=0)
        checked_parameter("exponent", self.exponent, above=0)

    @classmethod
    def from_limits(
        cls, speed_limit: float, task_speed: float, sigma_max_lower_bound: float = 1.0, gain: float = 1.0
    ) -> JParse:
        """The J-PARSE with the smallest γ that keeps ‖q̇‖ ≤ speed_limit wherever ‖ẋ‖ ≤ task_speed.

        γ = max(1, p) task_speed/(speed_limit · min_q σ₁(q)).

        Args:
            speed_limit: Bound on ‖q̇‖, rad/s or m/s.
            task_speed: Largest ‖ẋ‖.
            sigma_max_lower_bound: At most σ₁(q) for all q. A Jacobian of full twists of an arm whose last joint turns
                has σ₁ ≥ 1: that joint's column has an angular part of length 1.
            gain: p.

        Raises:
            InputError: Something is not > 0, or no γ < 1 does it.

        Source: J-PARSE 2025, eq. (51) to (53), with max(1, p), which is 1 there.
        """
        limits = {
            "speed_limit": speed_limit,
            "task_speed": task_speed,
            "sigma_max_lower_bound": sigma_max_lower_bound,
            "gain": gain,
        }
        for name, value in limits.items():
            checked_parameter(name, value, above=0)
        gamma = max(1.0, gain) * task_speed / (speed_limit * sigma_max_lower_bound)
        if gamma >= 1:
            raise InputError(
                f"no gamma < 1 keeps the joint speed below {speed_limit:g} at task speed {task_speed:g}: it would take "
                f"gamma = {gamma:.3g}; allow more joint speed or ask for less task speed"
            )
        return cls(gamma, gain)

    @property
    def relative(self) -> bool:
        """Yes."""
        return True

    @staticmethod
    def formula(
        s: Quantity, largest: Quantity, smallest: Quantity, product: Quantity, place: Quantity, p: Any
    ) -> Quantity:
        """1/σ above γσ₁, p (σ/(γσ₁))^(1/e)/(γσ₁) below."""
        level = np.maximum(s, where(largest > 0, p[0] * largest, 1.0))
        # Dividing twice keeps a tiny threshold from underflowing when squared.
        return where(s > p[0] * largest, 1.0, p[1]) * (s / level) ** p[2] / level

    @property
    def parameters(self) -> tuple[float, ...]:
        """γ, p, 1/e."""
        return (self.gamma, self.gain, 1 / self.exponent)

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
