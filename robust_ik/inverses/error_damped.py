"""Damping that vanishes with the task error: Newton's fast convergence near the goal, slow motion far from it."""

from __future__ import annotations

import abc
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_measures, check_leading_axes, checked_parameter
from robust_ik.inverses.base import Card, RobustInverse
from robust_ik.inverses.damped_least_squares import DampedLeastSquares
from robust_ik.inverses.damping_formulas import applied, damped_gain
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.svd import RANK_TOLERANCE, svd


def half_square(error: Array) -> Array:
    """E = ½‖e‖², (...)."""
    return np.asarray(0.5 * np.sum(error**2, axis=-1))


class ErrorDamped(RobustInverse):
    """J^T (J Jᵀ + λ²(e) I)⁻¹ ẋ, where λ² depends on E = ½‖e‖².

    `velocity` reads the error of the equation. `solve` takes ẋ for the error, as one step of a position-level solver.
    For weights in E use `Weighted`, which weighs the error like the rows.
    """

    @abc.abstractmethod
    def squared_damping(self, error: Array) -> Array:
        """λ² for task errors (..., m), shape (...)."""

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """The step (..., n) that removes the error ẋ; see `RobustInverse.solve`."""
        return self._damped(J, xdot, xdot)

    def velocity(self, equation: TaskEquation) -> Array:
        """q̇ for ẋ, damped by the error of the equation."""
        return self._damped(equation.J, equation.xdot, equation.error)

    def _damped(self, J: ArrayLike, xdot: ArrayLike, error: ArrayLike) -> Array:
        decomposition = svd(J)
        rows = decomposition.U.shape[-2]
        xdot, error = as_measures(xdot, "xdot", (rows,)), as_measures(error, "error", (rows,))
        check_leading_axes("J", decomposition.s.shape[:-1], "xdot", xdot.shape[:-1])
        check_leading_axes("J", decomposition.s.shape[:-1], "error", error.shape[:-1])
        s, squared = decomposition.s, self.squared_damping(error)[..., None]
        # Without an error there is no damping; then rounding must not count as a singular value.
        kept = np.hypot(s, np.sqrt(squared)) > RANK_TOLERANCE * s[..., :1]
        return applied(decomposition, damped_gain(kept * s, squared), xdot)


@dataclass(frozen=True)
class ChanLawrence(ErrorDamped):
    """λ² = k E with E = ½‖e‖²: undamped at the goal, so convergence is quadratic there.

    As a position-level step its length is at most 1/√(2k), whatever J is. An unreachable target keeps E > 0, so the
    arm comes to rest without chatter.

    Watch for: while a target is tracked closely, e is small and so is the damping: near a singularity it is then
    almost the pseudo-inverse. E mixes m and rad unless the rows are weighted.

    Attributes:
        gain: k > 0.

    Source: Chan and Lawrence 1988.
    """

    source: ClassVar[str] = "Chan-Lawrence 1988"
    card: ClassVar[Card] = Card(
        formula="σ/(σ² + k E), E = ½‖e‖²",
        largest_gain="none; as a step ‖Δq‖ ≤ 1/√(2k)",
        gain_at_zero="0 where e ≠ 0",
        exact="e → 0",
        continuity="continuous where e ≠ 0",
    )
    gain: float = 1.0

    def __post_init__(self) -> None:
        checked_parameter("gain", self.gain, above=0)

    def squared_damping(self, error: Array) -> Array:
        """λ² = k E."""
        return np.asarray(self.gain * half_square(error))


@dataclass(frozen=True)
class Sugihara(ErrorDamped):
    """λ² = E + w with E = ½‖e‖²: as Chan and Lawrence, with a floor that also holds at the goal.

    Watch for: nowhere exact, so convergence is linear in the end, with the fraction w/(σ² + w) left by every step.

    Attributes:
        bias: w > 0, in the units of σ²: 10⁻³ to 10⁻² times the square of a link's length.

    Source: Sugihara 2011.
    """

    source: ClassVar[str] = "Sugihara 2011"
    card: ClassVar[Card] = Card(
        formula="σ/(σ² + E + w), E = ½‖e‖²",
        largest_gain="1/(2√w)",
        gain_at_zero="0",
        exact="nowhere",
        continuity="continuous",
    )
    bias: float = 1e-3

    def __post_init__(self) -> None:
        checked_parameter("bias", self.bias, above=0)

    def squared_damping(self, error: Array) -> Array:
        """λ² = E + w."""
        return np.asarray(half_square(error) + self.bias)

    def largest_gain(self, sigma_max: float) -> float:
        """1/(2√w), for a small error and σ = √w; its value at σ₁ while σ₁ < √w."""
        return DampedLeastSquares(math.sqrt(self.bias)).largest_gain(sigma_max)
