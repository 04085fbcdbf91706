"""Damping from the ratio of successive manipulabilities: active only while the arm approaches a singularity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, RobustInverse
from robust_ik.inverses.damped_least_squares import DampedLeastSquares
from robust_ik.inverses.damping_formulas import apply_gains, damped_gain
from robust_ik.kinematics.svd import RANK_TOLERANCE, svd


@dataclass(frozen=True)
class KelmarKhosla(RobustInverse):
    """σ/(σ² + λ²) with λ = λ_f + λ₀ (1 − ρ) where ρ < ρ₀, else λ_f; ρ = w_t/w_{t−1} with w = Πσ.

    It has a memory: `begin` returns an inverse that remembers w from call to call. `solve` without it is the first
    call of a run, which has no past: it is damped by λ_f alone.

    Watch for: ρ → 1 as the time step → 0, so the damping depends on the sample rate. At rest *on* a singularity and
    on the way out of one ρ ≥ 1 and only the floor λ_f damps. For ρ₀ < 1 the damping jumps by λ₀ (1 − ρ₀). The
    formula is reconstructed from memory: two printed versions differ, and neither is in the texts at hand.

    Attributes:
        damping: λ₀ > 0, in the units of σ (squared inside); typically 0.05 to 0.1.
        ratio: ρ₀ in (0, 1]; 1 is the continuous choice.
        floor: λ_f > 0, always added.

    Source: Kelmar and Khosla 1990, with a floor.
    """

    source: ClassVar[str] = "Kelmar-Khosla 1990"
    card: ClassVar[Card] = Card(
        formula="σ/(σ² + λ²), λ = λ_f + λ₀ (1 − ρ) where ρ = w_t/w_{t−1} < ρ₀, else λ_f",
        largest_gain="1/(2λ_f)",
        gain_at_zero="0",
        exact="nowhere",
        continuity="continuous in J for ρ₀ = 1; depends on the past",
    )
    damping: float = 0.1
    ratio: float = 1.0
    floor: float = 1e-3

    def __post_init__(self) -> None:
        checked_parameter("damping", self.damping, above=0)
        checked_parameter("ratio", self.ratio, above=0)
        if self.ratio > 1:
            raise InputError(f"ratio must be > 0 and ≤ 1, got {self.ratio!r}")
        checked_parameter("floor", self.floor, above=0)

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """The first call of a run: damped by the floor alone; see `RobustInverse.solve`."""
        return self.begin(1.0).solve(J, xdot)

    def begin(self, dt: float) -> RobustInverse:  # noqa: ARG002
        """An inverse that remembers the manipulability between calls; dt does not enter the formula."""
        return _KelmarKhoslaRun(self)

    def damping_for(self, fall: ArrayLike) -> Array:
        """λ for fall = 1 − ρ, the part of the manipulability lost since the last call, ≤ 1."""
        fall = np.asarray(fall, dtype=float)
        approaching = fall > 1 - self.ratio
        return np.asarray(self.floor + self.damping * np.where(approaching, fall, 0.0))

    def largest_gain(self, sigma_max: float) -> float:
        """1/(2λ_f): the floor is always there."""
        return DampedLeastSquares(self.floor).largest_gain(sigma_max)


class _KelmarKhoslaRun(RobustInverse):
    source: ClassVar[str] = KelmarKhosla.source
    card: ClassVar[Card] = KelmarKhosla.card

    def __init__(self, inverse: KelmarKhosla) -> None:
        self.inverse = inverse
        self._last: Array | None = None

    def begin(self, dt: float) -> RobustInverse:
        return self.inverse.begin(dt)

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        decomposition = svd(J)
        now = _log_manipulability(decomposition.s)
        last = now if self._last is None else self._last
        if last.shape != now.shape:
            raise InputError(f"a run takes J of one batch shape, got {now.shape} after {last.shape}")
        damping = self.inverse.damping_for(_fall(last, now))[..., None]
        qdot = apply_gains(decomposition, damped_gain(decomposition.s, damping**2), xdot)
        self._last = now
        return qdot


def _log_manipulability(s: Array) -> Array:
    """Log Πσ, without overflow and underflow; −∞ at a singularity."""
    zero = s <= RANK_TOLERANCE * s[..., :1]  # rounding errors: their ratios mean nothing
    return np.asarray(np.where(zero.any(axis=-1), -np.inf, np.log(np.where(zero, 1.0, s)).sum(axis=-1)))


def _fall(last: Array, now: Array) -> Array:
    """1 − w_t/w_{t−1}, at least 0; 0 on the way out of a singularity and at rest on one."""
    change = np.where(np.isfinite(last), now - np.where(np.isfinite(last), last, 0.0), 0.0)
    return np.asarray(-np.expm1(np.minimum(change, 0.0)))
