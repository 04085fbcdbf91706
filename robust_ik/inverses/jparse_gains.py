"""J-PARSE with separate gains for position and orientation: in one solve, or in two priority levels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, as_measures, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, RobustInverse
from robust_ik.inverses.damping_formulas import applied
from robust_ik.inverses.weighted import check_linear_rows, leading_rows
from robust_ik.kinematics.svd import null_projector, svd


@dataclass(frozen=True)
class JParseWithGains(RobustInverse):
    """J-PARSE whose singular part is U_s Φ U_sᵀ K_s ẋ, with K_s = diag(k_p for linear rows, k_o for angular ones).

    For directions with σ > γσ₁ it is the pseudo-inverse. Along a singular direction u the speed is uᵀK_sẋ σ/(γσ₁)². As
    u mixes rows and K_s does not commute with u uᵀ, an error along another direction leaks in. With *one* singular
    direction the error decreases for every u if and only if |√k_p − √k_o| ≤ 2: (9, 1) is the limit, (15, 15) is fine,
    (15, 1) is refused.

    Watch for: with two singular directions, one of them lost, only k_p = k_o is safe whatever they are: in the worst
    case ½‖e‖² grows by ‖e‖² (k_p − k_o)²/(8 (k_p + k_o)) per second and unit of task gain. Gains other than 1 make q̇
    jump at the threshold; γ is relative, and σ₁ moves with q.

    Attributes:
        gamma: Threshold γ in (0, 1), relative to the largest singular value.
        position_gain: k_p > 0.
        orientation_gain: k_o > 0.
        linear_rows: How many of the first rows are linear; default 3, or all of them if there are fewer.
        allow_unstable: Accept gains that break the rule.

    Source: J-PARSE, section VII-B; the rule is ours.
    """

    source: ClassVar[str] = "J-PARSE 2025, section VII-B"
    card: ClassVar[Card] = Card(
        formula="1/σ where σ > γσ₁, else σ/(γσ₁)² on K_s ẋ",
        largest_gain="(max(1, (k_p + k_o)/2) + |k_p − k_o|/2)/(γσ₁)",
        gain_at_zero="0",
        exact="all σ > γσ₁",
        continuity="jumps at γσ₁ unless k_p = k_o = 1",
    )
    gamma: float = 0.1
    position_gain: float = 2.0
    orientation_gain: float = 2.0
    linear_rows: int | None = None
    allow_unstable: bool = False

    def __post_init__(self) -> None:
        _check(self.gamma, self.position_gain, self.orientation_gain, self.linear_rows)
        distance = abs(math.sqrt(self.position_gain) - math.sqrt(self.orientation_gain))
        if distance > 2 and not self.allow_unstable:
            raise InputError(
                f"|√position_gain − √orientation_gain| must be ≤ 2, got {distance:.3g} for {self.position_gain:g} and "
                f"{self.orientation_gain:g}: some singular direction would be driven away from its target"
            )

    @property
    def relative(self) -> bool:
        """Yes."""
        return True

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """Joint velocities; see `RobustInverse.solve`."""
        decomposition = svd(J)
        m = decomposition.U.shape[-2]
        xdot = as_measures(xdot, "xdot", (m,))
        linear = leading_rows(self.linear_rows, m)
        scaled = xdot * np.repeat([self.position_gain, self.orientation_gain], [linear, m - linear])
        s = decomposition.s
        threshold = self.gamma * s[..., :1]
        gains, kept = jparse_gains(s, threshold, 1.0), s > threshold
        return applied(decomposition, gains * kept, xdot) + applied(decomposition, gains * ~kept, scaled)

    def largest_gain(self, sigma_max: float) -> float:
        """A bound, from K_s = c I + Δ with c = (k_p + k_o)/2 and ‖Δ‖ = |k_p − k_o|/2; reached for k_p = k_o."""
        if sigma_max <= 0:
            return 0.0
        half = abs(self.position_gain - self.orientation_gain) / 2
        mean = (self.position_gain + self.orientation_gain) / 2
        return (max(1.0, mean) + half) / (self.gamma * sigma_max)


@dataclass(frozen=True)
class JParsePositionFirst(RobustInverse):
    """Position by J-PARSE on J_v, then orientation by J-PARSE on J_ω N with N = I − V_v V_vᵀ, the exact null space.

    q̇ = J_v# ẋ_v + (J_ω N)# (ẋ_ω − J_ω J_v# ẋ_v). The orientation never disturbs the position. Its threshold is
    relative to σ₁ of J_ω, not of J_ω N: so its speed stays bounded where J_ω N vanishes as a whole.

    Watch for: algorithmic singularities: J_ω N loses rank also where J_v and J_ω do not. Position and orientation are
    no longer traded off: a 6-joint arm that loses a direction of position keeps it lost.

    Attributes:
        gamma: Threshold γ in (0, 1), relative to σ₁ of J_v and of J_ω.
        position_gain: p > 0 of the first filter; 1 is the continuous choice.
        orientation_gain: p > 0 of the second one.
        linear_rows: How many of the first rows are linear; default 3, or all of them if there are fewer.

    Source: J-PARSE, section VII-B, items 1 and 2, as we read them.
    """

    source: ClassVar[str] = "J-PARSE 2025, section VII-B"
    card: ClassVar[Card] = Card(
        formula="J_v# ẋ_v + (J_ω N_v)# (ẋ_ω − J_ω J_v# ẋ_v), # = J-PARSE",
        largest_gain="max(1, k_p)/(γσ₁(J_v)) for the position",
        gain_at_zero="0",
        exact="σ > γσ₁; the position also where only the orientation is singular",
        continuity="continuous for gains of 1 where J_v keeps its rank",
    )
    gamma: float = 0.1
    position_gain: float = 1.0
    orientation_gain: float = 1.0
    linear_rows: int | None = None

    def __post_init__(self) -> None:
        _check(self.gamma, self.position_gain, self.orientation_gain, self.linear_rows)

    @property
    def relative(self) -> bool:
        """Yes."""
        return True

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """Joint velocities; see `RobustInverse.solve`."""
        J = as_array(J, "J", (None, None))
        m = J.shape[-2]
        xdot = as_measures(xdot, "xdot", (m,))
        linear = leading_rows(self.linear_rows, m)
        if linear in (0, m):  # rows are all linear or all angular
            gain = self.position_gain if linear else self.orientation_gain
            return _jparse(J, xdot, self.gamma * svd(J).s[..., :1], gain)
        Jv, Jw = J[..., :linear, :], J[..., linear:, :]
        qdot = _jparse(Jv, xdot[..., :linear], self.gamma * svd(Jv).s[..., :1], self.position_gain)
        left = xdot[..., linear:] - (Jw @ qdot[..., None])[..., 0]
        second = _jparse(Jw @ null_projector(Jv), left, self.gamma * svd(Jw).s[..., :1], self.orientation_gain)
        return qdot + second


def jparse_gains(s: Array, threshold: Array, gain: float) -> Array:
    """Gains 1/σ above the threshold, p σ/threshold² below, and 0 if both are 0; (..., k), threshold (..., 1)."""
    floored = np.maximum(s, threshold)
    safe = np.where(floored > 0, floored, 1.0)
    return np.asarray(np.where(s > threshold, 1.0, gain) * s / safe / safe)


def _jparse(J: Array, xdot: Array, threshold: Array, gain: float) -> Array:
    decomposition = svd(J)
    return applied(decomposition, jparse_gains(decomposition.s, threshold, gain), xdot)


def _check(gamma: float, position_gain: float, orientation_gain: float, linear_rows: int | None) -> None:
    checked_parameter("gamma", gamma, above=0, below=1)
    checked_parameter("position_gain", position_gain, above=0)
    checked_parameter("orientation_gain", orientation_gain, above=0)
    check_linear_rows(linear_rows)
