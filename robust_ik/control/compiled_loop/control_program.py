"""A controller's whole step as one compiled call, for stacks of one structure.

Tasks and limits without a compiled form take part with the rows and bounds that they give in Python.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.bounds import Bounds
from robust_ik.control.calming import Calming
from robust_ik.control.compiled_loop.curved_levels import curvature_room, curved_levels, mark_curved
from robust_ik.control.compiled_loop.resolver_program import (
    Compilable,
    ResolverProgram,
    eased_of,
    is_compilable,
    rows_together,
    second_order_of,
)
from robust_ik.control.compiled_loop.step_snapshot import Snapshot, is_ramped, yielding
from robust_ik.control.limits import JointLimits
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolvers import Resolver, TaskReconstruction
from robust_ik.control.resolvers.base import MAX_MEMORIES
from robust_ik.control.scaled_levels import Units
from robust_ik.control.tasks import Levels, Task
from robust_ik.control.tasks.compiled_form import CompiledForm, entries_of
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.chain import chain_layout as links
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.control_layout import MOST
from robust_ik.kinematics.svd import LARGEST_COMPILED
from robust_ik.robot.robot import Robot

POSE = 12
"""Numbers of a frame's pose on the desk; its Jacobian and the twists of its joints follow."""


def form_of(task: Task, robot: Robot) -> CompiledForm | None:
    """The form of a task for compiled code, if its class itself has one."""
    return task.form(robot) if "form" in vars(type(task)) else None


@dataclass(eq=False)
class Place:
    """A task's place in a program.

    Attributes:
        task: The task of the last step.
        record: Its record, a view of the program.
        level: Its level.
        rows: Its rows of the level.
        given: Whether its rows come from its `equation`.
        program: The whole program.
        numbers: What may change of it, by name, as views of the record.
    """

    task: Task
    record: Array
    level: int
    rows: slice
    given: bool
    program: Array
    numbers: dict[str, Array] = field(init=False)

    def __post_init__(self) -> None:
        kind = type(self.task)
        table = {} if self.given else kind.numbers
        self.numbers = {name: each.view(self.record) for name, each in table.items()}
        self._plain = kind.number is Task.number
        self._single = [(each.begin, name) for name, each in table.items() if each.shape == ()]
        self._others = [(view, name) for name, view in self.numbers.items() if view.ndim]
        self._form: Callable[[Task], Any] = attrgetter(*kind.structural) if kind.structural else type

    def take(self, task: Task, robot: Robot) -> None:
        """Takes another task of the same form: writes what may change of it into the record.

        Raises:
            InputError: The task does not fit the robot; the place still holds the one before.
        """
        record = self.record
        told = partial(getattr, task) if self._plain else partial(task.number, robot)
        values = [told(name) for _, name in self._others]
        for index, name in self._single:
            record[index] = told(name)
        for (view, _), value in zip(self._others, values):
            view[...] = value
        self.task = task

    def present(self, robot: Robot) -> Task:
        """The task with the numbers that its record has now.

        Raises:
            InputError: They are not valid.
        """
        if all(np.array_equal(view, self.task.number(robot, name)) for name, view in self.numbers.items()):
            return self.task
        told = {name: view.copy() if view.ndim else float(view) for name, view in self.numbers.items()}
        return self.task.with_numbers(robot, told)

    def alike(self, task: Task) -> bool:
        """Whether another task has the same form."""
        if type(task) is not type(self.task):
            return False
        return bool(self._form(task) == self._form(self.task))


class ControlProgram(ResolverProgram):
    """The compiled step of a stack of one structure.

    Attributes:
        places: The tasks' places in the program, level by level.
        dt: Length of a step, s.
        robot: The robot.
        calming: What the controller remembers of joints that turn back.
        curved: The levels of second order, by number.
    """

    def __init__(
        self,
        robot: Robot,
        resolver: Compilable,
        levels: Levels,
        dt: float,
        *,
        limits: JointLimits | None,
        units: Units,
        calming: Calming,
        forms: Sequence[Sequence[CompiledForm]],
        room: int = 0,
    ) -> None:
        """Makes a program.

        Args:
            robot: The robot.
            resolver: A resolver for which `is_compilable` holds, begun for a run.
            levels: The stack.
            dt: Length of a step, s.
            limits: Joint limits that are computed in compiled code; None if all bounds are put on the desk.
            units: The controller's units.
            calming: What the controller remembers of joints that turn back.
            forms: The forms of the tasks.
            room: Room for this many rows of bounds.
        """
        self.robot, self.dt, self.calming = robot, dt, calming
        self._levels, self._limits, self._units, self._forms = levels, limits, units, forms
        self._frames = dict.fromkeys(
            robot.tip if each is None else each
            for level in self._forms
            for form in level
            for each in ((form.frame,) if form.root is None else (form.frame, form.root))
            if form.framed
        )
        self.places: list[list[Place]] = []
        super().__init__(resolver, robot.n, [sum(form.height for form in level) for level in self._forms], dt, room)
        self._place_tasks()

    def _further(self, size: int, head: Array) -> list[Array]:
        """Joints, frames, chains, joint limits and tasks; see `ResolverProgram._further`."""
        robot, parts = self.robot, []

        def add(part: Array) -> int:
            nonlocal size
            parts.append(np.asarray(part, dtype=float).ravel())
            size += len(parts[-1])
            return size - len(parts[-1])

        head[slots.CONFIGURATION], head[slots.LENGTH] = robot.nq, self._units.length
        head[slots.MAP] = add(np.column_stack([*joint_places(robot), self._units.joints]))
        if np.isfinite(self.calming.peaks).any():
            head[slots.TURNING] = add(np.array([self.calming.peaks, self.calming.slowness]))
        chains = [robot.chain(frame) for frame in self._frames]
        places = [float(add(chain.packed)) for chain in chains]
        self._frame_table = np.column_stack([places, np.zeros(len(places))]) if places else np.zeros((0, 2))
        head[slots.FRAMES], head[slots.FRAME] = len(places), add(self._frame_table)
        self._frame_sizes = [POSE + 6 * robot.n + 6 * int(chain.packed[links.JOINTS]) for chain in chains]
        if self._limits is not None:
            told = self._limits
            head[slots.LIMITS] = add(np.array([told.acceleration, told.velocity, told.lower, told.upper]))
            add(np.array([told.recovery_speed, told.gain]))
            head[slots.HAS_SPEEDS], head[slots.HURRIED] = 1, np.isfinite(told.acceleration).any()
        mark_curved(head, self.resolver, self._forms)
        self._task_places = []
        for level, forms in enumerate(self._forms):
            at = slots.HEAD + level * slots.RECORD
            head[at + slots.TASKS], head[at + slots.TASK] = len(forms), size
            if any(form.record[slots.KIND] == slots.CLIMB for each in self._forms[: level + 1] for form in each):
                head[at + slots.BOUND] = 0  # without ∂J/∂q of such a task, the measure has no known gradient
            self._task_places.append([add(form.record) for form in forms])
        return parts

    def _more_room(self) -> list[tuple[int, int]]:
        first = int(self.program[slots.FRAME])
        asked = [(slots.ASKED, self.robot.nq), (slots.BEFORE, self.robot.n)]
        asked += curvature_room(self.program, self.robot.n, self._forms)
        return asked + [(first + 2 * index + 1, size) for index, size in enumerate(self._frame_sizes)]

    def _place_tasks(self) -> None:
        """Fills in what changes of the tasks, and the speed limits."""
        names = list(self._frames)
        for level, (tasks, forms, places) in enumerate(zip(self._levels, self._forms, self._task_places)):
            row, made = 0, []
            for task, form, at in zip(tasks, forms, places):
                record = self.program[at : at + len(form.record)]
                if form.framed:
                    record[slots.PLACE] = names.index(form.frame or self.robot.tip)
                    if record[slots.KIND] == slots.POSE:
                        record[slots.ROOT] = -1 if form.root is None else names.index(form.root)
                given = record[slots.KIND] == slots.GIVEN
                made.append(Place(task, record, level, slice(row, row + form.height), bool(given), self.program))
                made[-1].take(task, self.robot)
                row += form.height
            self.places.append(made)
        self._units_of_rows = [self._row_units(level) for level in range(len(self._levels))]
        self.follow(self.resolver)
        self._last = self.view(slots.LAST, self.robot.n)
        if self._limits is None:
            self.put_bounds(Bounds.free(self.robot.n))
        self.given = [place for level in self.places for place in level if place.given]
        if self._limits is not None:
            self.view(slots.SPEEDS, self.robot.n)[:] = self._limits.velocity / self._units.joints

    def _row_units(self, level: int) -> Array:
        """The units of a level's rows that compiled code makes."""
        found = np.ones(self.shape[1][level])
        for place in self.places[level]:
            record, kind = place.record, place.record[slots.KIND]
            if kind in (slots.POSE, slots.TWIST):
                chosen = record[slots.CHOSEN : slots.CHOSEN + int(record[slots.HEIGHT])]
                found[place.rows] = np.where(chosen < 3, self._units.length, 1.0)
            elif kind == slots.JOINT_VALUES:
                found[place.rows] = self._units.joints[entries_of(record)[:, slots.JOINT].astype(int)]
        return found

    def put_given(self, place: Place, equation: TaskEquation) -> None:
        """Puts the rows of a task without a form on the desk, in the controller's units."""
        desk, rows = self.levels[place.level], self._units.of_rows(equation)
        if not np.array_equal(self._units_of_rows[place.level][place.rows], rows):
            self._units_of_rows = [each.copy() for each in self._units_of_rows]  # snapshots hold the others
            self._units_of_rows[place.level][place.rows] = rows
        factor = equation.weight / rows
        desk.J[place.rows] = equation.J * factor[:, None] * self._units.joints
        desk.xdot[place.rows], desk.error[place.rows] = equation.xdot * factor, equation.error * factor
        if place.level in self.curved:
            H = equation.hessian
            self.curved[place.level].put_curvature(place.rows, None if H is None else H * factor[:, None, None])

    def put_rows(self, bounds: Bounds) -> None:
        """Puts the rows of bounds on the desk, in the controller's units."""
        count, n = len(bounds.floor), self.shape[0]
        self.program[slots.ROWS] = count
        if not count:
            return
        plain, units = self._units.length == 1.0, self._units
        rows, floor = self.view(slots.BOUND_ROWS, count, n), self.view(slots.FLOOR, count)
        rows[:] = bounds.rows if plain else bounds.rows * (units.joints / units.length)
        floor[:] = bounds.floor if plain else bounds.floor / units.length

    def step(self, q: Array, out: Array) -> int:
        """One step; motions that do not come from a gain formula come from the resolver. Returns a status."""
        status = self.run(self.setup, q, out, slots.BEGIN, 0)
        while status >= slots.WANTS_MOTION:
            level = status - slots.WANTS_MOTION
            share = float(self.calmed[slots.CALM_SHARE])
            equations = tuple(each.equation_at(share) for each in self.levels)
            problem = VelocityProblem(equations, Bounds.free(self.shape[0]), share=share)
            self.motion[:] = self.outside(problem, level)
            status = self.run(self.setup, q, out, level, 1)
            if status == slots.DONE:
                out[:] = self.qdot * self._units.joints
                self._last[:] = self.qdot
                self.calming.note(self.calmed, self.qdot, self.dt)
                self.program[slots.MADE] += 1
                status = slots.DONE if np.isfinite(out).all() else slots.TOO_LARGE
        return status

    def begin(self, previous: Array) -> None:
        """Puts the memory of the steps before on the desk: velocities, (n,), stopped levels, joints turning back."""
        self._last[:] = previous if self._units.length == 1.0 else previous / self._units.joints
        if self.eased_limiters:
            self.eased[:] = [each.speed for each in self.eased_limiters]
        self.calmed[:] = self.calming.memory
        for each in self.curved.values():
            each.begin()

    def restart(self, resolver: Resolver, calming: Calming) -> None:
        """Begins a new run, with a resolver that is equal to the one before but has begun anew, and nothing noted."""
        self.calming = calming
        self.follow(resolver)
        self.program[slots.MADE] = 0

    def follow(self, resolver: Resolver) -> None:
        """Remembers from now on with a resolver that is equal to the one before."""
        if is_compilable(resolver):
            self.resolver = resolver
            self.eased_limiters = eased_of(resolver)[: len(self.levels)]
            self.curved = curved_levels(self, self._forms)

    def put_memory(self, previous: Array, stopped: Array, noted: Array) -> None:
        """Puts another run's memory where steps begin: velocities, (n,), stopped levels, all else that is noted."""
        self._last[:] = previous / self._units.joints
        self.eased[:], self.noted[:] = stopped, noted
        self.keep()

    def yielded(self, bounds: Bounds) -> int:
        """How many limits have yielded to others among the rows of these bounds, in the step on the desk."""
        count = len(bounds.floor)
        marks = self.view(slots.FLOOR, 3, count)[2]
        if not marks.any():
            return 0
        names = yielding(bounds.row_cause, marks)
        return len(dict.fromkeys(names)) if is_ramped(self.program) else len(names)

    def keep(self) -> None:
        """Takes over the memory that the step has left."""
        self.calming.memory[:] = self.calmed
        self.keep_levels()

    def keep_levels(self) -> None:
        """Takes over what the step has left of levels that were stopped, and of levels of second order."""
        for each in self.curved.values():
            each.keep()
        if self.eased_limiters:
            for limiter, speed in zip(self.eased_limiters, self.eased.tolist()):
                limiter.speed = speed

    @property
    def whole(self) -> bool:
        """Whether a step is one compiled call: no rows and no motions come from outside."""
        ways = self.program[slots.HEAD + slots.WAY :: slots.RECORD][: len(self.levels)]
        return not self.given and not (ways == slots.OUTSIDE).any()

    @property
    def made(self) -> bool:
        """Whether the desk holds a step."""
        return bool(self.program[slots.MADE])

    @made.setter
    def made(self, made: bool) -> None:
        self.program[slots.MADE] = made

    @property
    def velocities(self) -> Array:
        """The velocities of the step on the desk, (n,), as a copy."""
        return self.qdot.copy() if self._units.length == 1.0 else self.qdot * self._units.joints

    @property
    def last(self) -> Array:
        """The last velocities, (n,), as a copy."""
        return self._last * self._units.joints

    def snapshot(self) -> Snapshot:
        """What the last step has left on the desk, to make its report from."""
        return Snapshot(
            self.program, self.desk[: int(self.program[slots.SCRATCH])].copy(), self._units_of_rows, self._units
        )

    def takes(self, levels: Levels, dt: float) -> bool:
        """Takes over the tasks of a stack, if it is of this structure, and steps of this length."""
        if dt != self.dt or len(levels) != len(self.places):
            return False
        others = []
        for tasks, places in zip(levels, self.places):
            if len(tasks) != len(places):
                return False
            for task, place in zip(tasks, places):
                if task is not place.task:
                    if not place.alike(task):
                        return False
                    others.append((place, task))
        for place, task in others:
            place.take(task, self.robot)
        return True


def joint_places(robot: Robot) -> tuple[Array, Array]:
    """The first place in q of every joint, and whether q holds cosine and sine there, (n,) each."""
    values = np.arange(1.0, robot.n + 1)
    turning = np.array([robot.description.joint[name].kind == "continuous" for name in robot.joint_names])
    before = np.cumsum(turning) - turning
    return values - 1 + before, turning.astype(float)


def fits(robot: Robot, resolver: Compilable, forms: Sequence[Sequence[CompiledForm]]) -> bool:
    """Whether kernels have room for a robot and for levels of tasks of these forms, and what the resolver needs.

    With levels of second order a row and a joint more must fit, and each of them has a memory of its own.
    """
    if isinstance(resolver, TaskReconstruction) and not all(_differentiable(each) for level in forms for each in level):
        return False
    rows = [sum(form.height for form in level) for level in forms]
    if any(second_order_of(resolver.inverse_of(level)) is not None for level in range(len(rows))):
        return len(rows) <= MAX_MEMORIES and max(robot.n, *rows) < LARGEST_COMPILED
    return max(robot.n, len(forms), rows_together(resolver, rows)) <= MOST


def _differentiable(form: CompiledForm) -> bool:
    """Whether compiled code knows ∂J/∂q of a task's rows, or NumPy does not know it either."""
    kind = form.record[slots.KIND]
    return bool(kind not in (slots.GIVEN, slots.POSE) or (kind == slots.POSE and form.root is None))
