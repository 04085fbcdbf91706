"""Makes the steps of one controller in compiled code where that is possible: the rest is left to NumPy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_parameter
from robust_ik.control.bounds import Bounds
from robust_ik.control.calming import Calming
from robust_ik.control.compiled_loop.control_program import ControlProgram, fits, form_of
from robust_ik.control.compiled_loop.resolver_program import eased_of, is_compilable, second_order_of
from robust_ik.control.compiled_loop.step_reports import StepReports, reports_of
from robust_ik.control.compiled_loop.step_snapshot import Snapshot
from robust_ik.control.limits import CollisionLimit, JointLimits, Limit
from robust_ik.control.resolution import LazyResolution, Resolution
from robust_ik.control.resolvers import Resolver
from robust_ik.control.scaled_levels import Units
from robust_ik.control.tasks import Levels, Task
from robust_ik.control.tasks.base import checked_equation
from robust_ik.control.tasks.compiled_form import CompiledForm, given_form
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control.control_layout import DONE
from robust_ik.robot.robot import Robot

KEPT = 4
"""Most programs that are kept, for stacks whose structure changes back and forth."""
ATTEMPTS = 4
"""Most times that a step is resolved until limits hold at its end; then NumPy goes on."""
ROOM = 64
"""Room for rows of bounds at first; more is made when it is needed. Chosen: arms near obstacles have up to a few dozen.
"""


@dataclass(frozen=True, eq=False)
class UnreadReport:
    """The report of a step that nobody has read yet; call it to make it.

    Attributes:
        steps: What has made the step.
        left: What it has left on its program's desk.
        rows: The bounds of limits that are not computed in compiled code.
    """

    steps: CompiledSteps
    left: Snapshot
    rows: Bounds | None

    def __call__(self) -> Resolution:
        """The report."""
        return self.steps.report(self.left, self.rows)


@dataclass(frozen=True, eq=False)
class Unkept:
    """A resolved step that breaks a limit at its end, whatever was asked for more: it can only be slower.

    Attributes:
        found: The step.
    """

    found: Resolution


class CompiledSteps:
    """The compiled steps of one controller.

    Attributes:
        robot: The robot.
        limits: The controller's limits, the strongest first.
        units: The controller's units.
    """

    def __init__(self, robot: Robot, limits: Sequence[Limit], units: Units) -> None:
        self.robot, self.limits, self.units = robot, tuple(limits), units
        first = self.limits[0] if self.limits else None
        others = self.limits[1:] if type(first) is JointLimits else self.limits
        self._of_rows = all(type(each) is CollisionLimit for each in others)
        self._joint = first if type(first) is JointLimits and self._of_rows else None
        self._others = others if self._joint is not None else self.limits
        self._watching = [limit for limit in self.limits if type(limit).tightened is not Limit.tightened]
        self._room = ROOM if self._others else 0
        self._programs: list[ControlProgram] = []

    def reports(self, unread: Sequence[UnreadReport]) -> StepReports | None:
        """The reports of steps of one program, or None if they have rows of bounds or are of several programs."""
        first = unread[0].left
        if any(each.rows is not None or not each.left.is_like(first) for each in unread):
            return None
        return reports_of(self.robot, self._joint, [each.left for each in unread])

    @property
    def asks_outside(self) -> bool:
        """Whether bounds have to be computed outside of compiled code."""
        return bool(self._others)

    @property
    def watches(self) -> bool:
        """Whether a limit looks at where a step ends."""
        return bool(self._watching)

    def __reduce__(self) -> tuple[object, ...]:
        # Without programs: they hold addresses of their own memory, which a copy does not share.
        return CompiledSteps, (self.robot, self.limits, self.units)

    def keep(self, program: ControlProgram, resolver: Resolver, calming: Calming) -> None:
        """Takes a program of an earlier run into one with a resolver that has begun anew."""
        program.restart(resolver, calming)
        self._programs = [program]

    def follow(self, resolver: Resolver) -> None:
        """Lets programs remember with a resolver that NumPy's steps have put in the place of the one before."""
        for program in self._programs:
            program.follow(resolver)

    def forget(self) -> None:
        """Drops all programs, since a new run begins."""
        self._programs = []

    def step(
        self, q: Array, levels: Levels, dt: float, resolver: Resolver, previous: Array, calming: Calming
    ) -> Resolution | Unkept | None:
        """A step, as `VelocityController.step`; None if NumPy has to make it, or to say what is wrong.

        Args:
            q: Configuration, (nq,).
            levels: The stack.
            dt: Length of the step, s.
            resolver: The resolver, begun for the run.
            previous: The last velocities, (n,).
            calming: What is remembered of joints that turn back; moved on.
        """
        program = self.program(q, levels, dt, resolver, calming)
        if program is None or (program.given and not self._given(program, q)):
            return None
        out, rows = np.empty(self.robot.n), None
        if self._others:
            rows = self._bounds(self._others, q, previous, dt)
            if len(rows.floor) > program.room:
                self._room = 2 * len(rows.floor)
                self.forget()
                return None
        if rows is None:
            program.begin(previous)
            if program.step(q, out) != DONE:
                return None
            program.keep()
        else:
            made = self._within_rows(program, q, out, rows, previous)
            if not isinstance(made, Bounds):
                return made
            rows = made
        return self.unread(program, out, rows)

    def prepared(self, program: ControlProgram, q: Array, out: Array) -> Bounds | Unkept | None:
        """A step of a prepared loop whose bounds are computed outside of compiled code in part.

        Args:
            program: The program, whose tasks are those of the step and whose desk has the memory of the steps before.
            q: Configuration, (nq,).
            out: Array for the velocities, (n,).

        Returns:
            The bounds of limits that are not computed in compiled code; a step that has to be slower; None if NumPy has
            to make the step, or to say what is wrong. In both of these cases the memory is as before.
        """
        previous = program.last
        program.keep()
        rows = self._bounds(self._others, q, previous, program.dt)
        found: Bounds | Unkept | None = None
        if len(rows.floor) <= program.room:
            found = self._within_rows(program, q, out, rows, previous)
        if not isinstance(found, Bounds):
            program.begin(previous)
        return found

    def unread(self, program: ControlProgram, qdot: Array, rows: Bounds | None) -> Resolution:
        """The resolution of the step that is on a program's desk, whose report is made when it is read.

        Args:
            program: The program.
            qdot: The velocities, (n,); they become read-only.
            rows: The bounds of limits that are not computed in compiled code.
        """
        qdot.flags.writeable = False
        return LazyResolution.of(qdot, UnreadReport(self, program.snapshot(), rows))

    def program(
        self, q: ArrayLike, levels: Levels, dt: float, resolver: Resolver, calming: Calming
    ) -> ControlProgram | None:
        """The program of a stack with its present tasks; None if it has none."""
        for program in self._programs:
            if program.resolver is resolver and program.takes(levels, dt):
                return program
        dt = checked_parameter("dt", dt, above=0)
        if not is_compilable(resolver):
            return None
        if not all(type(task).begin is Task.begin for level in levels for task in level):
            return None
        others = [each for each in resolver.inverses if second_order_of(each) is None]
        if any(inverse.begin(dt) is not inverse for inverse in others):
            return None  # inverses with a memory must not see steps that are made again
        if any(inverse.needs_hessian for inverse in others):
            return None  # motions from outside are of first order
        if (eased := eased_of(resolver)) and len(levels) > len(eased):
            return None
        forms = [[self._form(task, q) for task in level] for level in levels]
        if self._joint is not None:
            self._joint.bounds(self.robot, self.robot.rest, np.zeros(self.robot.n), dt)  # raises for another robot
        if not fits(self.robot, resolver, forms):
            return None
        program = ControlProgram(
            self.robot, resolver, levels, dt, limits=self._joint, units=self.units, calming=calming, forms=forms,
            room=self._room,
        )  # fmt: skip
        self._programs = [program, *self._programs[: KEPT - 1]]
        return program

    def _form(self, task: Task, q: ArrayLike) -> CompiledForm:
        """The form of a task; without one of its own, that of as many rows as its equation has."""
        return form_of(task, self.robot) or given_form(len(self._equation(task, q).xdot))

    def _equation(self, task: Task, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        return checked_equation(task, task.equation(self.robot, q, hessian=hessian), self.robot)

    def _given(self, program: ControlProgram, q: Array) -> bool:
        """Puts the rows of tasks without a form on the desk; False if they are not as many as before."""
        for level in program.curved.values():
            level.see()
        for place in program.given:
            equation = self._equation(place.task, q, hessian=place.level in program.curved)
            if len(equation.xdot) != place.rows.stop - place.rows.start:
                self.forget()
                return False
            program.put_given(place, equation)
        return True

    def _bounds(self, limits: Sequence[Limit], q: Array, previous: Array, dt: float) -> Bounds:
        """The bounds of limits, the strongest first."""
        *stronger, weakest = limits
        bounds = weakest.bounds(self.robot, q, previous, dt)
        for limit in reversed(stronger):
            bounds = bounds.within(limit.bounds(self.robot, q, previous, dt))
        return bounds

    def _within_rows(
        self, program: ControlProgram, q: Array, out: Array, rows: Bounds, previous: Array
    ) -> Bounds | Unkept | None:
        """Makes a step that keeps limits of rows at its end too; see `prepared`, and `VelocityController._resolved`.

        Of a step that has to be slower, what its levels have left is remembered.
        """
        found: Resolution | None = None
        fewest = 0
        for _ in range(ATTEMPTS):
            if self._joint is not None:
                program.put_rows(rows)
            else:
                program.put_bounds(self.units.bounds(rows))
            program.begin(previous)
            if program.step(q, out) != DONE:
                return None
            yielded = program.yielded(rows)
            tighter = self.tightened(q, out, program.dt, rows)
            if tighter is None:
                program.keep()
                return rows
            if found is not None and yielded > fewest:
                break  # no more can be asked for
            if len(tighter.floor) > program.room:
                return None
            found, fewest = self.unread(program, out.copy(), rows), yielded
            rows = tighter
        if found is None:
            return None
        program.keep_levels()
        return Unkept(found)

    def tightened(self, q: Array, qdot: Array, dt: float, bounds: Bounds) -> Bounds | None:
        """The tighter bounds of the first limit that asks for them; None if no limit does."""
        for limit in self._watching:
            tighter = limit.tightened(self.robot, q, qdot, dt, bounds)
            if tighter is not None:
                return tighter
        return None

    def report(self, left: Snapshot, rows: Bounds | None) -> Resolution:
        """The report of a step.

        Args:
            left: What it has left on its program's desk.
            rows: The bounds of limits that are not computed in compiled code.
        """
        bounds = Bounds.free(self.robot.n) if rows is None else rows
        if self._joint is not None:
            bounds = bounds.within(self._joint.bounds(self.robot, left.q, left.previous, left.dt))
        return left.resolution(bounds)
