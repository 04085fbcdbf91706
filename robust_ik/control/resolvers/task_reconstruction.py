"""Task reconstruction: keeps each level's measure of manipulability above a bound by changing its task velocity."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from robust_ik.checks import Array, checked_parameter
from robust_ik.checks.public_arguments import check_type
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolvers.priority_resolver import PriorityResolver, Settled
from robust_ik.control.within_bounds.filtered_motion import level_gains
from robust_ik.control.within_bounds.limiters import Limiter, Scaling
from robust_ik.control.within_bounds.null_space import Reduced
from robust_ik.errors import InputError
from robust_ik.inverses import JParse, SingularValueFilter
from robust_ik.inverses.task_equation import TaskEquation, stacked
from robust_ik.kinematics.singular_value_gradients import manipulability_gradient
from robust_ik.kinematics.svd import least_norm_solution, manipulability

SMALL = 1e-12
"""Gradients and measures below this are rounding beside 1, and are never divided by."""


def smooth(share: float) -> float:
    """x² (3 − 2x): rises from 0 to 1 with slope 0 at both ends."""
    return share * share * (3 - 2 * share)


@dataclass(frozen=True)
class TaskReconstruction(PriorityResolver):
    """Task priority whose levels stay clear of kinematic and algorithmic singularities.

    The measure of level i is mᵢ = √det(JᵢNᵢ₋₁ (JᵢNᵢ₋₁)ᵀ). Below m̄ᵢ, the component of the level's velocity that makes
    mᵢ fall is removed, completely below m̄ᵢ/2, where the level is also led back up. So once mᵢ ≥ m̄ᵢ/2 holds it remains
    true, up to the length of a step. Changes of mᵢ by levels above are compensated (drift compensation), and lower
    levels may not make a higher level's measure fall either.

    If limits slow a level, the bound may be violated; if a measure is exactly zero, the way up is unknown.
    Measures mix units and grow with the arm: `measure_bounds` finds bounds for a robot and a stack.

    Attributes:
        bound: m̄ of every level, or one for each, the last one for all further levels; 0 for levels that are not
            changed.
        recovery: κ > 0, speed of the way back up, in units of the task per s.
        shape: A function on [0, 1] with values 0 to 1: how much of the component is removed, from m̄ to m̄/2.
        compensate: Whether changes of a measure by other levels are compensated. The paper's form does not, and lets
            the measure of a second task fall below its bound: to 0.102 instead of 0.15 on `kim_two_tasks`.
        printed_sign: The sign of the recovery term as printed in eq. (22), which drives the measure down. Only to show
            the difference.

    Source: Kim, Marani, Chung, Yuh, eq. (16) to (26), with the sign of (22) corrected and the drift that (26) leaves
    out.
    """

    source: ClassVar[str] = "Kim-Marani-Chung-Yuh, eq. (16)-(26)"
    inverse: SingularValueFilter | Sequence[SingularValueFilter] = field(default_factory=lambda: JParse(gamma=0.01))
    limiter: Limiter = field(default_factory=Scaling)
    bound: float | Sequence[float] = 0.05
    recovery: float = 0.2
    shape: Callable[[float], float] = field(default=smooth, repr=False)
    compensate: bool = True
    printed_sign: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        check_type("compensate", self.compensate, "bool")
        check_type("printed_sign", self.printed_sign, "bool")
        if not all(isinstance(each, SingularValueFilter) for each in self.inverses):
            raise InputError(f"TaskReconstruction takes filters such as JParse(), got {self.inverse!r}")
        check_type("bound", self.bound, "float | Sequence[float]")
        if np.ndim(self.bound) == 0:
            object.__setattr__(self, "bound", checked_parameter("bound", self.bound, least=0))
        if not self.bounds:
            raise InputError("bound must be one number or one for each level, got none")
        for each in self.bounds:
            checked_parameter("bound", each, least=0)
        checked_parameter("recovery", self.recovery, above=0)
        if not callable(self.shape):
            raise InputError(f"shape must be a function from [0, 1] to [0, 1], got {self.shape!r}")

    @property
    def bounds(self) -> tuple[float, ...]:
        """m̄ of the levels, the last one for all further ones."""
        return (self.bound,) if isinstance(self.bound, (int, float)) else tuple(self.bound)

    @property
    def needs_hessian(self) -> bool:
        """Yes: gradients of the measures need them."""
        return True

    def motion(self, settled: Settled) -> Array:
        """The level's motion, reconstructed; see `PriorityResolver.motion`."""
        reduced = settled.reduced[-1]
        gains = level_gains(settled.inverse, reduced)
        guards = [self._guard(settled.problem, settled.reduced, index) for index in range(settled.index + 1)]
        wanted, own = settled.missing, guards[-1]
        if own is not None:
            effect = reduced.U @ (gains * (reduced.Vt @ own.slope))
            drift = float(own.slope @ settled.qdot) if self.compensate else 0.0
            wanted = self._reconstructed(wanted, effect, drift, own, settled.problem.share * self.recovery)
        motion = (wanted @ reduced.U * gains) @ reduced.Vt
        return self._sparing(motion, guards, settled) if self.compensate else motion

    def _guard(self, problem: VelocityProblem, reduced: Sequence[Reduced], index: int) -> _Guard | None:
        """The guard of a level's measure; None if it is far above its bound or cannot be computed."""
        bound = self.bounds[min(index, len(self.bounds) - 1)]
        each = reduced[index]
        measure = each.measure
        if not 0 < measure < bound:
            return None
        slope = measure_gradient(problem.levels[: index + 1], measure)
        return None if slope is None else _Guard(measure, bound, slope)

    def _share(self, measure: float, bound: float) -> float:
        """k(m, m̄): 0 above m̄, 1 below m̄/2."""
        return float(self.shape(min(max((bound - measure) / (bound / 2), 0.0), 1.0)))

    def _reconstructed(self, wanted: Array, effect: Array, drift: float, guard: _Guard, recovery: float) -> Array:
        """Eqs. (21)-(22), corrected: `effect` is the gradient of the measure in task space, g (J N)#."""
        size = float(np.linalg.norm(effect))
        if size <= SMALL:
            return wanted
        upwards = effect / size
        rate = float(upwards @ wanted) + drift / size
        falling = min(rate, 0.0) * self._share(guard.measure, guard.bound)
        sign = -1.0 if self.printed_sign else 1.0
        rising = sign * recovery * self._share(guard.measure, guard.bound / 2)
        return wanted + (rising - falling) * upwards

    def _sparing(self, motion: Array, guards: Sequence[_Guard | None], settled: Settled) -> Array:
        """The motion without the part that lowers measures of levels above; the level's own measure is unchanged."""
        rows, changes = [], []
        for guard in guards[:-1]:
            if guard is None:
                continue
            before = float(guard.slope @ settled.qdot)
            fall = min(before + float(guard.slope @ motion), 0.0) - min(before, 0.0)
            if fall < 0:
                rows.append(settled.freedom.project(guard.slope))
                changes.append(-fall * self._share(guard.measure, guard.bound))
        if not rows:
            return motion
        own = guards[-1]
        for kept in ([own], []) if own is not None else ([],):
            directions = np.array([*rows, *(settled.freedom.project(each.slope) for each in kept)])
            lengths = np.linalg.norm(directions, axis=1)
            if lengths.min() <= SMALL:
                continue
            change = least_norm_solution(
                directions / lengths[:, None], np.array([*changes, *(0.0 for _ in kept)]) / lengths
            )
            if change is not None:
                return motion + change
        return motion


@dataclass(frozen=True, eq=False)
class _Guard:
    """A measure below its bound, and its gradient (n,)."""

    measure: float
    bound: float
    slope: Array


def measure_gradient(levels: Sequence[TaskEquation], measure: float) -> Array | None:
    """∂mᵢ/∂q of the last of the levels, (n,), without differentiating projectors; None without Hessians.

    The measure m_st of stacked levels is the product of their measures, so ∂mᵢ = (∂m_st,i − mᵢ ∂m_st,i₋₁)/m_st,i₋₁.

    Args:
        levels: The level and those before it.
        measure: Its measure.
    """
    whole = stacked(levels)
    if whole.hessian is None:
        return None
    slope = manipulability_gradient(whole.J, whole.hessian)
    if len(levels) == 1:
        return slope
    above = stacked(levels[:-1])
    others = float(manipulability(above.J))
    if above.hessian is None or others <= SMALL or not math.isfinite(others):
        return None
    return np.asarray((slope - measure * manipulability_gradient(above.J, above.hessian)) / others)
