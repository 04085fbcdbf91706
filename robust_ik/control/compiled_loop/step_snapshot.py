"""What a compiled step has left on its desk: its report is made from it when somebody reads it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.control.bounds import Bounds
from robust_ik.control.compiled_loop.resolver_program import LevelDesk
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolution import Resolution
from robust_ik.control.resolvers.step_status import verdict
from robust_ik.control.scaled_levels import Units
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.control_layout import FIRST_STAGE, SECOND_STAGE


@dataclass(eq=False)
class Snapshot:
    """What a step has left on the desk.

    Attributes:
        program: The program.
        desk: A copy of the desk, but for its scratch.
        row_units: The units of the rows of each level.
        units: The controller's units.
    """

    program: Array
    desk: Array
    row_units: list[Array]
    units: Units

    def is_like(self, other: Snapshot) -> bool:
        """Whether it is of the same program, with rows in the same units."""
        return self.program is other.program and self.row_units is other.row_units

    @property
    def q(self) -> Array:
        """The configuration of the step, (nq,)."""
        at = int(self.program[slots.ASKED])
        return self.desk[at : at + int(self.program[slots.CONFIGURATION])]

    @property
    def previous(self) -> Array:
        """The velocities of the step before, (n,)."""
        at = int(self.program[slots.BEFORE])
        return self.desk[at : at + len(self.units.slides)] * self.units.joints

    @property
    def dt(self) -> float:
        """The length of the step, s."""
        return float(self.program[slots.DT])

    def resolution(self, bounds: Bounds) -> Resolution:
        """The report of the step within these bounds."""
        units = self.units
        levels = [LevelDesk.of(self.program, self.desk, level) for level in range(int(self.program[slots.LEVELS]))]
        at, n = int(self.program[slots.QDOT]), int(self.program[slots.JOINTS])
        share = float(self.desk[int(self.program[slots.CALM]) + slots.CALM_NOW])
        equations = tuple(each.equation_at(share) for each in levels)
        problem = VelocityProblem(equations, self._yielded(units.bounds(bounds)), self.dt, share)
        shares = [float(each.found[slots.SHARE]) for each in levels]
        found = verdict(problem, self.desk[at : at + n].copy(), shares, [each.reduced for each in levels])
        if units.length == 1.0:
            return found
        metric = tuple(replace(each, residual=each.residual * rows) for each, rows in zip(found.levels, self.row_units))
        return replace(found, qdot=readonly(found.qdot * units.joints), levels=metric)

    def _yielded(self, bounds: Bounds) -> Bounds:
        """Bounds, in the controller's units, with the rows that the step has not kept among what yielded."""
        count, at = len(bounds.floor), int(self.program[slots.FLOOR])
        floors, _, marks = self.desk[at : at + 3 * count].reshape(3, count)
        if not marks.any():
            return bounds
        ramped = is_ramped(self.program)
        names = yielding(bounds.row_cause, marks)
        if ramped:  # as by `priority_resolver`: found with the bounds as they were asked for
            return replace(bounds, contradictions=tuple(dict.fromkeys([*bounds.contradictions, *names])))
        return replace(bounds, floor=np.minimum(bounds.floor, floors), contradictions=(*bounds.contradictions, *names))


def is_ramped(program: Array) -> bool:
    """Whether levels are resolved first, and velocities change towards them then."""
    return bool(program[slots.HURRIED] > 0 and program[slots.RESOLVER] == slots.WALK)


def yielding(causes: Sequence[str], marks: Array) -> list[str]:
    """The causes of marked rows, in the order in which they yielded."""
    stages = marks.astype(int)
    return [cause for stage in (FIRST_STAGE, SECOND_STAGE) for cause, mark in zip(causes, stages) if mark & stage]
