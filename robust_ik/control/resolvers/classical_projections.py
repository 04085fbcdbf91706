"""Common projections of secondary motions, for comparison. Not for use."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolution import Resolution
from robust_ik.control.resolvers.base import InverseResolver
from robust_ik.control.resolvers.step_status import reductions, verdict


@dataclass(frozen=True)
class LeakingPriority(InverseResolver):
    """q̇ = J₁# ẋ₁ + (I − J₁# J₁) q̇₀ with J₁# itself in the projector, q̇₀ = J₂# ẋ₂, and so on down the levels.

    Right for the pseudo-inverse only: the projector with a damped # removes only σφ(σ) of q̇₀ along each direction, so
    that (1 − σφ(σ)) of it leaks into the task and holds it off its target, at any distance from singularities. Speed
    bounds cut each joint.

    Source: J-PARSE 2025, eq. (54) as its reference code has it for the damped inverses.
    """

    source: ClassVar[str] = "J-PARSE 2025, eq. (54), as its reference code has it"

    def resolve(self, problem: VelocityProblem) -> Resolution:
        """See `Resolver.resolve`."""
        n = len(problem.bounds.lower)
        qdot, projector = np.zeros(n), np.eye(n)
        for index, equation in enumerate(problem.levels):
            inverse = self.inverse_of(index)
            qdot = qdot + projector @ inverse.velocity(equation)
            given = np.array([inverse.solve(equation.J, column) for column in equation.J.T]).T
            projector = projector @ (np.eye(n) - given)
        bounded = np.clip(qdot, problem.bounds.lower, problem.bounds.upper)
        return verdict(problem, bounded, [1.0] * len(problem.levels), reductions(problem))
