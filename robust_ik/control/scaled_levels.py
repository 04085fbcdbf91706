"""Levels and bounds in an arm's own unit of length, for arms far from the size of a metre. Arrays only.

Inverses and resolvers compare rows of metres with rows of radians: in thresholds relative to σ₁, in damping, in ranks.
That makes sense for arms of about a metre. For others, rows in metres and joints that slide are divided by a length
scale L, and results are multiplied by it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array, readonly
from robust_ik.control.bounds import Bounds
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolution import Resolution
from robust_ik.inverses.task_equation import TaskEquation


@dataclass(frozen=True, eq=False)
class Units:
    """A unit of length instead of the metre.

    Attributes:
        length: L, m.
        slides: Which joints slide, (n,).
    """

    length: float
    slides: NDArray[np.bool_]

    @cached_property
    def joints(self) -> Array:
        """The units of the joints, (n,)."""
        return np.where(self.slides, self.length, 1.0)

    def of_rows(self, equation: TaskEquation) -> Array:
        """The units of an equation's rows, (m,)."""
        return np.ones(len(equation.xdot)) if equation.lengths is None else np.where(equation.lengths, self.length, 1.0)

    def problem(self, given: VelocityProblem) -> VelocityProblem:
        """The problem in these units."""
        if self.length == 1.0:
            return given
        return replace(
            given, levels=tuple(self._equation(each) for each in given.levels), bounds=self.bounds(given.bounds)
        )

    def resolution(self, given: VelocityProblem, found: Resolution) -> Resolution:
        """The resolution in metres, except for singular values, which stay in these units."""
        if self.length == 1.0:
            return found
        levels = tuple(
            replace(level, residual=level.residual * self.of_rows(equation))
            for level, equation in zip(found.levels, given.levels)
        )
        return replace(found, qdot=readonly(found.qdot * self.joints), levels=levels)

    def _equation(self, given: TaskEquation) -> TaskEquation:
        rows, joints, H = self.of_rows(given), self.joints, given.hessian
        return replace(
            given,
            J=given.J / rows[:, None] * joints,
            xdot=given.xdot / rows,
            error=given.error / rows,
            hessian=None if H is None else H / rows[:, None, None] * joints[:, None] * joints,
        )

    def bounds(self, given: Bounds) -> Bounds:
        """Bounds in these units; rows are of distances, which are divided too."""
        if self.length == 1.0:
            return given
        joints, hurried = self.joints, given.unhurried
        return replace(
            given,
            lower=given.lower / joints,
            upper=given.upper / joints,
            rows=given.rows * joints / self.length,
            floor=given.floor / self.length,
            unhurried=None if hurried is None else (hurried[0] / joints, hurried[1] / joints),
            last=None if given.last is None else given.last / joints,
            fastest=None if given.fastest is None else given.fastest / joints,
        )
