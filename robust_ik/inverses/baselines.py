"""Common controllers near singularities, for comparison: they slow down or stop. Not for use."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, RobustInverse
from robust_ik.inverses.moore_penrose import MoorePenrose
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.svd import svd


@dataclass(frozen=True)
class SlowDown(RobustInverse):
    """s J⁺ ẋ, with s falling from 1 to 0 as the condition number σ₁/σ_k rises from `lower` to `stop`.

    It slows down only on the way towards the singularity: if the motion lets σ_k grow, s is 1, even beyond `stop`.
    `solve` cannot tell the two apart, and always slows down. MoveIt Servo does the same, judging by σ_k alone.

    Watch for: at and beyond `stop` nothing moves until another motion is asked for, even if a large part of the motion
    has nothing to do with the singularity.

    Attributes:
        lower: Condition number above which it slows down.
        stop: Condition number at which it stops.

    Source: MoveIt Servo, velocity scaling for singularities (parameters lower_singularity_threshold and
    hard_stop_singularity_threshold, defaults 17 and 30).
    """

    source: ClassVar[str] = "MoveIt Servo"
    card: ClassVar[Card] = Card(
        formula="s J⁺ẋ, s = (stop − κ)/(stop − lower) between, κ = σ₁/σ_k",
        largest_gain="κ at lower, about lower/σ₁ and at the most (stop/2)²/((stop − lower)σ₁)",
        gain_at_zero="0 towards it; 1/σ away from it",
        exact="κ ≤ lower",
        continuity="jumps where the motion turns from towards to away",
    )
    lower: float = 17.0
    stop: float = 30.0

    def __post_init__(self) -> None:
        checked_parameter("lower", self.lower, least=1)
        checked_parameter("stop", self.stop, above=0)
        if self.stop < self.lower:
            raise InputError(f"lower ≤ stop must hold, got {self.lower:g} and {self.stop:g}")

    @property
    def needs_hessian(self) -> bool:
        """Yes: it shows whether a motion leads towards the singularity."""
        return True

    @property
    def relative(self) -> bool:
        """Yes: the condition number has no unit."""
        return True

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """Joint velocities s J⁺ ẋ, as if every motion led towards the singularity; see `RobustInverse.solve`."""
        s = svd(J).s
        return np.asarray(self.share(s)[..., None] * MoorePenrose().solve(J, xdot))

    def velocity(self, equation: TaskEquation) -> Array:
        """Joint velocities s J⁺ ẋ, with s = 1 if σ_k grows along it."""
        qdot = MoorePenrose().solve(equation.J, equation.xdot)
        found = svd(equation.J)
        share = float(self.share(found.s))
        if share < 1 and equation.hessian is not None:
            # σ_k grows by uᵀ (Σ ∂J/∂q_k q̇_k) v.
            growth = found.U[:, -1] @ (equation.hessian @ qdot) @ found.Vt[-1]
            share = 1.0 if growth > 0 else share
        return np.asarray(share * qdot)

    def share(self, s: ArrayLike) -> Array:
        """The factor s on the speed, from singular values (..., k), descending."""
        s = as_array(s, "s", (None,))
        with np.errstate(divide="ignore", invalid="ignore"):
            condition = np.where(s[..., -1] > 0, s[..., 0] / s[..., -1], math.inf)
            between = (self.stop - condition) / (self.stop - self.lower)
        return np.asarray(np.where(condition <= self.lower, 1.0, np.where(condition >= self.stop, 0.0, between)))


@dataclass(frozen=True)
class StopAtSingularity(RobustInverse):
    """J⁺ ẋ, or zero once σ₁/σ_k reaches `stop`: the built-in guard of many robots.

    Watch for: it never moves again by itself.

    Attributes:
        stop: Condition number.

    Source: J-PARSE 2025, section VIII, on the robots' own controllers.
    """

    source: ClassVar[str] = "robots' own controllers"
    card: ClassVar[Card] = Card(
        formula="J⁺ẋ for σ₁/σ_k < stop, else 0",
        largest_gain="stop/σ₁",
        gain_at_zero="0",
        exact="σ₁/σ_k < stop",
        continuity="jumps at σ₁/stop",
    )
    stop: float = 30.0

    def __post_init__(self) -> None:
        checked_parameter("stop", self.stop, least=1)

    @property
    def relative(self) -> bool:
        """Yes: the condition number has no unit."""
        return True

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """J⁺ ẋ or zero; see `RobustInverse.solve`."""
        s = svd(J).s
        moves = s[..., -1] * self.stop > s[..., 0]
        return np.where(moves[..., None], MoorePenrose().solve(J, xdot), 0.0)

    def largest_gain(self, sigma_max: float) -> float:
        """stop/σ₁."""
        return self.stop / sigma_max


BASELINES: tuple[type[RobustInverse], ...] = (SlowDown, StopAtSingularity)
"""Inverses for comparison only; not in `CLASSES`."""
