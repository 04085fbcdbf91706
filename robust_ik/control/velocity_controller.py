"""One control step: joint velocities within limits, from a stack of tasks at q."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.checks import Array, as_measures, checked_parameter, is_plain
from robust_ik.checks.public_arguments import check_type
from robust_ik.control.bounds import CONTRADICTION, Bounds
from robust_ik.control.calming import Calming
from robust_ik.control.compiled_loop.compiled_steps import CompiledSteps, Unkept
from robust_ik.control.compiled_loop.control_program import ControlProgram
from robust_ik.control.length_scale import chosen_length_scale
from robust_ik.control.limits import JointLimits, Limit
from robust_ik.control.limits.base import checked_limits
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolution import Resolution
from robust_ik.control.resolvers import Resolver, TaskPriority
from robust_ik.control.resolvers.base import InverseResolver
from robust_ik.control.resolvers.step_status import reductions, verdict
from robust_ik.control.scaled_levels import Units
from robust_ik.control.tasks import Levels, Stack, Task, checked_stack
from robust_ik.control.tasks.base import Drive, Moment, checked_equation
from robust_ik.errors import InputError
from robust_ik.inverses import JParse, RobustInverse
from robust_ik.inverses.task_equation import TaskEquation, stacked
from robust_ik.robot.robot import Robot

ATTEMPTS = 4
"""Most times that a step is resolved until limits hold at its end."""
SHARES = (0.5, 0.25, 0.1, 0.03, 0.01, 0.0)
"""Fractions to which the speed of a step is reduced if no resolving makes it keep its limits."""

LESS = 0.5
"""A slower motion takes the place of a faster one that breaks a limit, too, if it breaks it by less than this part."""
GAMMA = 0.01
"""γ of a controller's default J-PARSE; `benchmarks/default_inverse.py` compares it with other inverses.

A larger γ, such as the paper's 0.1, is slow near singular configurations; a smaller one is faster there.
"""

SLOWER = 20
"""Most times that a step is slowed if its tasks do not allow it."""

SAME = 1e-4
"""Least relative change of the largest velocity for which slowing continues."""

HALVINGS = 8
"""Number of halvings between a step that its tasks do not allow, and braking."""

TINY = 1e-300
"""Least divisor, instead of zero."""


class VelocityController:
    """Turns a stack of tasks into joint velocities that respect limits, step after step.

    A controller has the state of one run: the last velocities, for acceleration limits, and the memories of inverses
    and tasks. `reset` begins a new run.

    Attributes:
        robot: The robot.
        resolver: The resolver.
        length_scale: The resolver's unit of length, m: 1, or for much larger or smaller robots about their own size.
        qdot: The joint velocities of the last step, (n,); at rest before the first.
        compiled: What makes its steps in compiled code where that is possible; NumPy makes the others.
        calming: What it remembers of joints that turn back.
    """

    def __init__(
        self,
        robot: Robot,
        resolver: Resolver | RobustInverse | None = None,
        limits: Sequence[Limit] | Limit | None = None,
        *,
        length_scale: float | None = None,
        calm: bool = True,
    ) -> None:
        """A controller at rest.

        Args:
            robot: The robot.
            resolver: A resolver; an inverse stands for `TaskPriority` with it; default
                `TaskPriority(JParse(gamma=0.01), steady=True)`.
            limits: Limits; if they contradict each other, the first wins. Default the robot's own position and
                speed limits, `JointLimits.of(robot)`; () for none.
            length_scale: L, m per rad: rows in metres, and joints that slide, are divided by it before they are
                resolved. Default `robot.length_scale`, 1 m for robots of usual size; 1 if an inverse has weights of
                rows or a length scale of its own.
            calm: Whether all tasks ask for a smaller share of their speed once joints turn to and fro, see `calming`.
                Without, a loop that is not stable shakes on: to compare methods, or for motions that are meant to turn
                back more than three times a second.

        Raises:
            InputError: An argument is of another type.
        """
        if not isinstance(robot, Robot):
            raise InputError(f"robot must be a Robot, as rik.load gives it, got {robot!r}")
        self.robot = robot
        self.resolver = as_resolver(resolver)
        inverses = self.resolver.inverses if isinstance(self.resolver, InverseResolver) else ()
        self.length_scale = chosen_length_scale(robot, inverses, length_scale)
        self._units = Units(self.length_scale, robot.sliding)
        check_type("calm", calm, "bool")
        self._calm = calm
        self.calming = Calming(np.zeros(robot.n), np.zeros(robot.n))
        self.limits = JointLimits.of(robot) if limits is None else limits
        self.reset()

    @property
    def calm(self) -> bool:
        """Whether tasks ask for less once joints turn to and fro."""
        return self._calm

    @property
    def limits(self) -> tuple[Limit, ...]:
        """The limits, the strongest first; others may be set."""
        return self._limits

    @limits.setter
    def limits(self, limits: Sequence[Limit] | Limit) -> None:
        self._limits = checked_limits(limits)
        self.compiled = CompiledSteps(self.robot, self._limits, self._units)
        noted = self.calming.memory
        self.calming = Calming.of(self.robot, self._limits, self._units, calm=self._calm)
        self.calming.memory[:] = noted

    def reset(self, qdot: ArrayLike | None = None) -> None:
        """Begins a new run.

        Args:
            qdot: Present joint velocities of the robot, (n,); default at rest.
        """
        start = np.zeros(self.robot.n) if qdot is None else as_measures(qdot, "qdot", (self.robot.n,))
        if start.ndim != 1:
            raise InputError(f"qdot must be the velocities of one configuration, got shape {start.shape}")
        self.qdot = start.copy()
        self.calming = Calming.of(self.robot, self._limits, self._units, calm=self._calm)
        self._driver: Resolver | None = None
        self.compiled.forget()
        self._drives: dict[tuple[int, int], Drive] = {}

    def step(self, q: ArrayLike, stack: Stack | Task, dt: float) -> Resolution:
        """Joint velocities for the step from q.

        Args:
            q: Configuration, (nq,).
            stack: Levels of tasks, the most important first; [task, task] stands for one level with both, one task for
                [[task]].
            dt: Length of the step, s.

        Returns:
            Joint velocities, (n,), the result of each level, and the limits that act. Limits that contradict each other
            are a status, not an error.

        Raises:
            InputError: q is not one finite configuration, the stack is no list of lists of tasks, dt is not > 0.
            FrameNotFoundError: A task names a frame that the robot does not have.
        """
        levels = checked_stack(stack)
        if not is_plain(q, self.robot.nq):
            q = np.array(as_measures(q, "q", ()))
            if q.ndim != 1:
                raise InputError(f"a step takes one configuration, (nq,), got shape {q.shape}")
        made = self.compiled.step(q, levels, dt, self.begun(dt), self.qdot, self.calming)
        if isinstance(made, Resolution):
            self.qdot, self._drives = made.qdot, {}
            return made
        return self.finish(as_measures(q, "q", ()), levels, checked_parameter("dt", dt, above=0), made)

    def finish(self, q: Array, levels: Levels, dt: float, made: Unkept | None) -> Resolution:
        """A step of which compiled code has made nothing, or one that must be slower; arguments are checked already."""
        problem = self._problem(q, levels, dt)
        found = self._resolved(q, problem, dt) if made is None else self._slowed(q, problem, made.found, dt)
        resolution = self._within_shares(q, problem, found)
        self.qdot = resolution.qdot
        self.calming.watch(resolution.qdot / self._units.joints, dt)
        self.compiled.follow(self.begun(dt))
        return resolution

    def program(self, stack: Stack | Task, dt: float) -> ControlProgram | None:
        """The compiled program of a stack in the present run, see `ControlLoop`; None if NumPy makes its steps."""
        return self.compiled.program(self.robot.rest, checked_stack(stack), dt, self.begun(dt), self.calming)

    def begun(self, dt: float) -> Resolver:
        """The resolver, begun for the present run; dt is the length of its steps, s, if it has none yet."""
        if self._driver is None:
            self._driver = self.resolver.begin(checked_parameter("dt", dt, above=0))
        return self._driver

    def _resolved(self, q: Array, problem: VelocityProblem, dt: float) -> Resolution:
        """The resolution; if its step in full would break a limit, another one that does not."""
        begun = self.begun(dt)
        remembers = begun is not self.resolver  # trial steps that are dropped must not be remembered
        tried, found = problem, None
        for _ in range(ATTEMPTS):
            self._driver = copy.deepcopy(begun) if remembers and self.compiled.watches else begun
            latest = self._units.resolution(tried, self._driver.resolve(self._units.problem(tried)))
            if found is not None and len(latest.contradictions) > len(found.contradictions):
                if self.compiled.tightened(q, latest.qdot, dt, tried.bounds) is None:
                    return latest
                break  # no more can be asked for
            found = latest
            tighter = self.compiled.tightened(q, found.qdot, dt, tried.bounds)
            if tighter is None:
                return found
            tried = replace(problem, bounds=tighter)
        return self._slowed(q, problem, found or latest, dt)

    def _within_shares(self, q: Array, problem: VelocityProblem, found: Resolution) -> Resolution:
        """The part of the motion that drives allow, as far as bounds allow it to be slower."""
        qdot, bounds, kept, share = found.qdot, problem.bounds, 1.0, self._share(q, found.qdot)
        for _ in range(SLOWER):  # joints at acceleration limits cannot be slower: then the others are
            slower = np.clip(share * qdot, bounds.lower, bounds.upper)
            held = bounds.last is not None and np.abs(slower - qdot).max() <= SAME * np.abs(qdot).max()
            if share >= 1 or held or not bounds.contains(slower):
                break
            qdot, kept = slower, share * kept
            share = self._share(q, qdot)
        if share < 1 and bounds.last is not None:
            braked = self._nearer_to_braking(q, bounds, bounds.last, qdot)
            better = bounds.contains(braked) and self._share(q, braked) > share
            if better and self.compiled.tightened(q, braked, problem.dt, bounds) is None:
                kept *= float(np.clip(braked @ qdot / max(float(qdot @ qdot), TINY), 0.0, 1.0))
                qdot = braked
        if qdot is found.qdot:
            return found
        return self._verdict(problem, qdot, kept * found.scale, found, np.zeros(len(bounds.floor), dtype=bool))

    def _share(self, q: Array, qdot: Array) -> float:
        """The least share of a motion that any drive allows."""
        return min((drive.share(q, qdot) for drive in self._drives.values()), default=1.0)

    def _nearer_to_braking(self, q: Array, bounds: Bounds, last: Array, qdot: Array) -> Array:
        """A motion, (n,), that drives allow, as near to `qdot` as possible on the line from braking to it.

        In braking, all joints keep their ratios and brake as hard as acceleration limits let the slowest of them; a
        joint whose other limits require it brakes harder. If drives do not allow braking either, it is returned all the
        same.
        """
        lower, upper = bounds.unhurried or (bounds.lower, bounds.upper)
        held = (last != 0.0) & (lower <= 0.0) & (upper >= 0.0)  # not those coming back to their limits
        slowest = np.clip(0.0, bounds.lower, bounds.upper)[held] / last[held]
        braking = np.clip(np.max(np.clip(slowest, 0.0, 1.0), initial=0.0) * last, bounds.lower, bounds.upper)
        least, most = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = 0.5 * (least + most)
            allowed = self._share(q, braking + middle * (qdot - braking)) >= 1
            least, most = (middle, most) if allowed else (least, middle)
        return np.asarray(braking + least * (qdot - braking))

    def _slowed(self, q: Array, problem: VelocityProblem, found: Resolution, dt: float) -> Resolution:
        """The fastest part of the motion that keeps all limits; if none does, the one that breaks them least."""
        bounds = problem.bounds
        least, best = math.inf, (1.0, found.qdot, np.zeros(len(bounds.floor), dtype=bool))
        for share in (1.0, *SHARES):
            qdot = np.clip(share * found.qdot, bounds.lower, bounds.upper)
            tighter = self.compiled.tightened(q, qdot, dt, bounds)
            missed = bounds.rows @ qdot < bounds.floor - CONTRADICTION
            if tighter is None:
                return self._verdict(problem, qdot, share * found.scale, found, missed)
            count = len(bounds.floor)
            more = tighter.floor - tighter.rows @ qdot
            raised = np.flatnonzero(tighter.floor[:count] > bounds.floor)
            names = {*(bounds.row_cause[row] for row in raised), *tighter.row_cause[count:]}
            asked = float(np.max(np.r_[more[raised], more[count:]], initial=0.0))
            if asked < LESS * least:
                broken = missed | np.array([cause in names for cause in bounds.row_cause], dtype=bool)
                least, best = asked, (share, qdot, broken)
        share, qdot, broken = best
        return self._verdict(problem, qdot, share * found.scale, found, broken)

    def _verdict(
        self, problem: VelocityProblem, qdot: Array, scales: Array, found: Resolution, yielded: NDArray[np.bool_]
    ) -> Resolution:
        """The resolution for other joint velocities in place of those found; rows that yielded are named."""
        names = [*found.contradictions, *(cause for cause, yields in zip(problem.bounds.row_cause, yielded) if yields)]
        bounds = replace(problem.bounds, contradictions=tuple(dict.fromkeys(names)))
        problem = replace(problem, bounds=bounds)
        told = self._units.problem(problem)
        answer = verdict(told, qdot / self._units.joints, scales.tolist(), reductions(told))
        return self._units.resolution(problem, answer)

    def _problem(self, q: Array, stack: Levels, dt: float) -> VelocityProblem:
        bounds = Bounds.free(self.robot.n)
        for limit in reversed(self.limits):
            bounds = bounds.within(limit.bounds(self.robot, q, self.qdot, dt))
        drives, self._drives = self._drives, {}  # those of tasks that are no longer in the stack end
        for place in ((i, j) for i, level in enumerate(stack) for j in range(len(level))):
            task, drive = stack[place[0]][place[1]], drives.get(place)
            drive = drive if drive is not None and drive.continues(task) else task.begin(self.robot, self.limits)
            if drive is not None:
                self._drives[place] = drive
        levels = tuple(
            stacked([self._equation((i, j), task, q, Moment(bounds, self.qdot, dt)) for j, task in enumerate(level)])
            for i, level in enumerate(stack)
        )
        self.calming.look_at(stack, self.robot, dt)
        share = self.calming.share
        if share < 1.0:
            levels = tuple(replace(each, xdot=share * each.xdot) for each in levels)
        return VelocityProblem(levels, bounds, dt, share)

    def _equation(self, place: tuple[int, int], task: Task, q: Array, moment: Moment) -> TaskEquation:
        """The equation of the task at a place of the stack, by its drive if it has one."""
        hessian, drive = self.resolver.needs_hessian, self._drives.get(place)
        if drive is None:
            return checked_equation(task, task.equation(self.robot, q, hessian=hessian), self.robot)
        return checked_equation(task, drive.equation(task, q, moment, hessian=hessian), self.robot)


def as_resolver(given: Resolver | RobustInverse | None) -> Resolver:
    """A resolver, `TaskPriority` with an inverse, or the default.

    Raises:
        InputError: It is neither.
    """
    if given is None:
        return TaskPriority(JParse(gamma=GAMMA), steady=True)
    if isinstance(given, RobustInverse):
        return TaskPriority(given)
    if not isinstance(given, Resolver):
        raise InputError(
            f"resolver must be a resolver such as TaskPriority(), or an inverse such as JParse(), got {given!r}"
        )
    return given
