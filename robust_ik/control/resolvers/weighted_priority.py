"""All levels at once, weighted against each other: soft priorities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from robust_ik.checks import Array, checked_parameter
from robust_ik.checks.public_arguments import check_type
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolution import Resolution
from robust_ik.control.resolvers.base import InverseResolver
from robust_ik.control.resolvers.step_status import reductions, verdict
from robust_ik.control.within_bounds.bounded_qp import REGULARISATION, check_backend, share_of, solve_within
from robust_ik.control.within_bounds.feasible_start import feasible_start
from robust_ik.control.within_bounds.filtered_motion import filtered_motion
from robust_ik.control.within_bounds.motion_cost import motion_cost
from robust_ik.control.within_bounds.null_space import Freedom
from robust_ik.control.within_bounds.overshoot_limit import steadied
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import length


@dataclass(frozen=True)
class WeightedPriority(InverseResolver):
    """Minimises Σᵢ wᵢ ‖Jᵢ q̇ − Jᵢ Jᵢ# ẋᵢ‖² within the bounds: levels trade off against each other.

    Each level is first filtered by its robust inverse #, so that none asks for motion that a singularity takes away.
    Lower levels do disturb higher ones, by about the ratio of their weights: use `TaskPriority` if they must not.

    Attributes:
        inverse: The robust inverse of every level, or a sequence of them, the last one for all further levels.
        weights: Weight of each level, > 0; the last two continue as a geometric sequence: (1, 1e-3) gives the third
            1e-6.
        backend: A solver that qpsolvers knows; "daqp" comes with this package.
        steady: Whether a level goes no further in a step than it can without overshooting, see `steadying`.
    """

    source: ClassVar[str] = "Escande-Mansard-Wieber 2014, the weighted case, on filtered tasks"
    weights: Sequence[float] = (1.0, 1e-3)
    backend: str = "daqp"
    steady: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        given = self.weights if isinstance(self.weights, (list, tuple)) else ()
        if not given:
            raise InputError(f"weights must be one number > 0 for each level, got {self.weights!r}")
        object.__setattr__(self, "weights", tuple(checked_parameter("weights", each, above=0) for each in given))
        check_backend(self.backend)
        check_type("steady", self.steady, "bool")

    def weight_of(self, level: int) -> float:
        """The weight of a level, from 0."""
        beyond = level - len(self.weights) + 1
        if beyond <= 0:
            return self.weights[level]
        ratio = self.weights[-1] / self.weights[-2] if len(self.weights) > 1 else 1.0
        return float(self.weights[-1] * ratio**beyond)

    def resolve(self, problem: VelocityProblem) -> Resolution:
        """See `Resolver.resolve`."""
        start, bounds = feasible_start(problem.bounds)
        problem = replace(problem, bounds=bounds)
        rows, wanted = self._weighted(problem)
        free = _regularised(rows, wanted)
        if bounds.contains(free, 0.0):
            return verdict(problem, free, [1.0] * len(problem.levels), reductions(problem))
        metric = self._metric(problem)
        change = solve_within(metric, metric @ (start - free), np.eye(len(start)), bounds, start, self.backend)
        qdot = np.clip(start + change, bounds.lower, bounds.upper)
        return verdict(
            problem, qdot, [share_of(each.J @ free, each.J @ qdot) for each in problem.levels], reductions(problem)
        )

    def _metric(self, problem: VelocityProblem) -> Array:
        """Cost of motions, (n, n), largest entry 1: Σᵢ wᵢ Hᵢ for motions that move levels, plus the largest floor.

        As in `motion_cost` for each level, so that joints stopped by limits do not make the others go back and forth.
        """
        n = len(problem.bounds.lower)
        whole, metric, largest = Freedom.whole(n), np.zeros((n, n)), 0.0
        for level, equation in enumerate(problem.levels):
            reduced = whole.reduce(equation.J)
            cost = motion_cost(reduced, problem.dt * length(equation.xdot))
            size = self.weight_of(level) * reduced.own[0] ** 2
            moving = cost.directions[:, : cost.rank]
            metric += size * (moving * cost.weights[: cost.rank]) @ moving.T
            largest = max(largest, size * cost.floor)
        metric += (largest or 1.0) * np.eye(n)
        return np.asarray(metric / np.abs(metric).max())

    def _weighted(self, problem: VelocityProblem) -> tuple[Array, Array]:
        """All levels as one: filtered, with every row times the root of its level's weight."""
        whole = Freedom.whole(len(problem.bounds.lower))
        rows, wanted = [], []
        for level, equation in enumerate(problem.levels):
            reduced = whole.reduce(equation.J)
            motion = filtered_motion(self.inverse_of(level), reduced, equation, equation.xdot, whole)
            if self.steady:
                motion = steadied(motion, reduced, equation.xdot, problem.dt)
            root = np.sqrt(self.weight_of(level))
            rows.append(root * equation.J)
            wanted.append(root * (equation.J @ motion))
        return np.concatenate(rows), np.concatenate(wanted)


LEAST = 1e-12
"""Scale of the regularisation if nothing is asked."""


def _regularised(rows: Array, wanted: Array) -> Array:
    """The q̇ that minimises ‖rows q̇ − wanted‖² + ε ‖q̇‖², without squares of `rows`, which lose half the digits."""
    n = rows.shape[1]
    root = np.sqrt(REGULARISATION * max(float(np.sum(rows * rows)), LEAST))
    rows, wanted = np.concatenate([rows, root * np.eye(n)]), np.concatenate([wanted, np.zeros(n)])
    Q, R = np.linalg.qr(rows)
    return np.asarray(np.linalg.solve(R, Q.T @ wanted))
