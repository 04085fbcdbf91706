"""Tracks a sequence of points or poses, step by step, and reports Lyapunov's function. Arrays only."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_parameter, readonly
from robust_ik.errors import InputError
from robust_ik.inverses.base import RobustInverse

Difference = Callable[[Array, Array], Array]


@dataclass(frozen=True, eq=False)
class TrackingReport:
    """Report of a run of N steps; row k of an array belongs to the k-th target.

    Attributes:
        q: Configurations, (N + 1, nq).
        steps: Δθ, (N, n).
        error: e_k, target minus actual, (N + 1, m).
        lyapunov: V_k = ½‖e_k‖², (N + 1,).
    """

    q: Array
    steps: Array
    error: Array
    lyapunov: Array

    @property
    def lyapunov_change(self) -> Array:
        """ΔV_k = V_{k+1} − V_k, (N,): negative where the error shrinks."""
        return np.diff(self.lyapunov)


@dataclass(frozen=True)
class TrackingLoop:
    """Δθ = J* (K_i [x_d(k+1) − x_d(k)] + K_p e_k) with e_k = x_d(k) − f(θ_k), for any inverse J*.

    K_i multiplies the *increment* of the target, K_p the *proportional* error. If J J* = I/α₀ along a
    line, the error settles at (α₀ − K_i)/K_p times the step: at 5.6 steps for ESRIM's α₀ = 1.7.

    Watch for: ΔV_k is positive while the error builds up to that lag, also far from singularities. σ₀ = 1.3 means
    mm and rad: wrap the inverse in `Weighted` with a length scale of 0.001 m.

    Attributes:
        inverse: J*.
        increment_gain: K_i ≥ 0, a pure number.
        error_gain: K_p > 0 per step, a pure number; stable for K_p σφ(σ) < 2.

    Source: ESRIM 2020, eq. (30) to (33), rebuilt from its text and gains.
    """

    inverse: RobustInverse
    increment_gain: float = 1.0
    error_gain: float = 0.125

    def __post_init__(self) -> None:
        if not isinstance(self.inverse, RobustInverse):
            raise InputError(f"inverse must be a RobustInverse, got {self.inverse!r}")
        checked_parameter("increment_gain", self.increment_gain, least=0)
        checked_parameter("error_gain", self.error_gain, above=0)

    def run(
        self,
        targets: ArrayLike,
        q0: ArrayLike,
        *,
        forward: Callable[[Array], Array],
        jacobian: Callable[[Array], Array],
        difference: Difference = np.subtract,
        integrate: Difference = np.add,
    ) -> TrackingReport:
        """Follows the targets one by one.

        Args:
            targets: x_d(0) to x_d(N): points (N + 1, m), or poses (N + 1, 4, 4) with a `difference` for them.
            q0: Configuration to start from, (nq,).
            forward: q → point or pose of the arm, of the type of the targets.
            jacobian: q → J, (m, n), for the error that `difference` gives.
            difference: (a, b) → a − b, (m,).
            integrate: (q, Δθ) → next q.

        Raises:
            InputError: There are fewer than two targets, or a number is NaN or infinite since the arm diverged.
        """
        goals = as_array(targets, "targets", (None,))
        q = as_array(q0, "q0", (None,))
        if len(goals) < 2 or q.ndim != 1:
            raise InputError(f"two targets and one q0 are needed, got shapes {goals.shape} and {q.shape}")
        inverse = self.inverse.begin(1.0)
        qs, steps, errors = [q], [], [difference(goals[0], forward(q))]
        for goal, following in pairwise(goals):
            wanted = self.increment_gain * difference(following, goal) + self.error_gain * errors[-1]
            steps.append(inverse.solve(jacobian(qs[-1]), wanted))
            qs.append(integrate(qs[-1], steps[-1]))
            errors.append(difference(following, forward(qs[-1])))
        error = readonly(as_array(errors, "the error", (None, None)))
        return TrackingReport(readonly(qs), readonly(steps), error, readonly(0.5 * np.sum(error**2, axis=-1)))
