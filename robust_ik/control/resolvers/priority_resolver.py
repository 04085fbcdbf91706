"""The walk down the levels that strict resolvers share."""

from __future__ import annotations

import abc
import copy
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from robust_ik.checks import Array, checked_parameter
from robust_ik.checks.public_arguments import check_type
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolution import Resolution
from robust_ik.control.resolvers.base import MAX_MEMORIES, InverseResolver
from robust_ik.control.resolvers.step_status import verdict
from robust_ik.control.within_bounds.acceleration_ramp import ramped
from robust_ik.control.within_bounds.feasible_start import feasible_start
from robust_ik.control.within_bounds.level_fit import Wish
from robust_ik.control.within_bounds.limiters import Eased, Limiter, Sliding
from robust_ik.control.within_bounds.null_space import Freedom, Reduced
from robust_ik.control.within_bounds.overshoot_limit import steadied
from robust_ik.errors import InputError
from robust_ik.inverses import RobustInverse
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.svd import length


@dataclass(frozen=True, eq=False)
class Settled:
    """The state of the resolution when a level's turn comes.

    Attributes:
        problem: The problem.
        index: The level, from 0.
        inverse: Its inverse.
        qdot: Joint velocities settled by the start and the levels above, (n,).
        freedom: The freedom left by the levels above.
        reduced: Each level's Jacobian in the freedom left to it, down to this level.
    """

    problem: VelocityProblem
    index: int
    inverse: RobustInverse
    qdot: Array
    freedom: Freedom
    reduced: tuple[Reduced, ...]

    @property
    def equation(self) -> TaskEquation:
        """The level's equation."""
        return self.problem.levels[self.index]

    @property
    def missing(self) -> Array:
        """ẋ − J q̇, the task velocity that the level still misses, (m,)."""
        return self.equation.xdot - self.equation.J @ self.qdot


@dataclass(frozen=True)
class PriorityResolver(InverseResolver):
    """Levels one after another; each moves in the freedom left by those before, fitted into the bounds by a limiter.

    Attributes:
        inverse: The robust inverse of every level, or a sequence of them, the last one for all further levels.
        limiter: How a level's motion is fitted into the bounds.
        release: Task directions with σ ≤ release·σ₁ are left to lower levels; 0 for none. More than 0 lets lower levels
            use a joint direction that a singularity frees, at the cost of a jump and of moving the task by that much.
        steady: Whether a level goes no further in a step than it can without overshooting, for any inverse, see
            `steadying`. In fast motion and long steps, directions are then given up earlier than by the inverse.
    """

    limiter: Limiter = field(default_factory=Sliding)
    release: float = 0.0
    steady: bool = field(default=False, kw_only=True)
    _eased: tuple[Eased, ...] = field(default=(), init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.limiter, Limiter):
            raise InputError(
                f"limiter must be Sliding(), Saturation(), QuadraticProgram() or Scaling(), got {self.limiter!r}"
            )
        checked_parameter("release", self.release, least=0, below=1)
        check_type("steady", self.steady, "bool")

    def begin(self, dt: float) -> Self:
        """See `Resolver.begin`; limiters that stop a whole level then let it start again slowly."""
        begun = super().begin(dt)
        if not self.limiter.stops:
            return begun
        begun = copy.copy(begun)
        object.__setattr__(begun, "_eased", tuple(Eased(self.limiter, dt) for _ in range(MAX_MEMORIES)))
        return begun

    @property
    def eased(self) -> tuple[Eased, ...]:
        """The limiters of the levels of a run, with their memory; none for a limiter that stops no level."""
        return self._eased

    def _limiter_of(self, level: int) -> Limiter:
        """The limiter of a level, from 0."""
        return self._eased[level] if level < len(self._eased) else self.limiter

    @abc.abstractmethod
    def motion(self, settled: Settled) -> Array:
        """The motion that a level wants in addition to what is settled, (n,); its part outside the freedom is cut."""

    def resolve(self, problem: VelocityProblem) -> Resolution:
        """See `Resolver.resolve`."""
        qdot, bounds = feasible_start(problem.bounds.lasting)
        lasting = replace(problem, bounds=bounds)
        freedom, scales, aims = Freedom.whole(len(qdot)), [], []
        reduced: tuple[Reduced, ...] = ()
        for index, equation in enumerate(problem.levels):
            reduced = (*reduced, freedom.reduce(equation.J, self.release))
            settled = Settled(lasting, index, self.inverse_of(index), qdot, freedom, reduced)
            motion = freedom.project(self.motion(settled))
            if self.steady:
                motion = steadied(motion, reduced[-1], settled.missing, problem.dt)
            stride = problem.dt * length(settled.missing)
            wish = Wish(qdot, motion, reduced[-1], freedom, bounds, stride, problem.dt)
            change, scale = self._limiter_of(index).limit(wish)
            qdot = np.clip(qdot + change, bounds.lower, bounds.upper)
            scales.append(scale)
            aims.append(qdot)
            freedom = Freedom(reduced[-1].below)
        if problem.bounds.last is None or not aims:
            return verdict(lasting, qdot, scales, reduced)
        qdot, shares, contradictions = ramped(aims, problem.bounds, self.limiter, reduced)
        yielded = tuple(dict.fromkeys([*bounds.contradictions, *contradictions]))
        bounds = replace(problem.bounds, contradictions=yielded)
        return verdict(replace(problem, bounds=bounds), qdot, [a * b for a, b in zip(scales, shares)], reduced)
