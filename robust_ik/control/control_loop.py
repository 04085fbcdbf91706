"""ControlLoop: a controller's steps with one stack, prepared so that a step is one compiled call."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, as_measures, checked_out, checked_parameter, is_plain
from robust_ik.control.bounds import Bounds
from robust_ik.control.compiled_loop.compiled_steps import Unkept
from robust_ik.control.compiled_loop.control_program import Place
from robust_ik.control.compiled_loop.many_runs import MOST_SEED, LoopRuns, RunPlan, make_runs, places_of
from robust_ik.control.resolution import Resolution
from robust_ik.control.tasks import Levels, Stack, Task, checked_stack
from robust_ik.control.velocity_controller import VelocityController
from robust_ik.errors import InputError, suggest
from robust_ik.inverses.weighted import check_whole
from robust_ik.kernels.control.control_layout import BEGIN, DONE, UNLIKE


class LoopTask:
    """A task of a loop: its targets and gains can be set in place.

    Its attributes are those of the task that may change: `target`, `feedforward`, `twist`, `gain`, `max_linear`, ...
    Arrays are views of what the next step reads, so `loop.tasks[0][0].target[:] = T` moves the target. `target` of a
    `PostureTask` or `JointTask` holds joint values, one for each of its joints. What makes the task another one, its
    frame or rows, cannot change.
    """

    def __init__(self, place: Place) -> None:
        vars(self).update(_place=place)

    def __getattr__(self, name: str) -> Any:
        place: Place | None = vars(self).get("_place")
        if place is None or name not in place.numbers:
            raise AttributeError(name if place is None else _unknown(place, name))
        view = place.numbers[name]
        return view if view.ndim else float(view)

    def __setattr__(self, name: str, value: Any) -> None:
        place: Place = self._place
        if name not in place.numbers:
            raise AttributeError(_unknown(place, name))
        view = place.numbers[name]
        if not view.ndim:
            infinite = isinstance(value, float) and value == math.inf and name not in FINITE
            view[...] = value if infinite else checked_parameter(name, value, above=0)
            return
        given = as_measures(value, name, view.shape)
        if given.shape != view.shape:
            raise InputError(f"{name} must have shape {view.shape}, got {given.shape}")
        view[...] = given

    def __dir__(self) -> list[str]:
        return sorted(self._place.numbers)

    def __repr__(self) -> str:
        return f"LoopTask({type(self._place.task).__name__}: {', '.join(self._place.numbers)})"


def _unknown(place: Place, name: str) -> str:
    kind = type(place.task).__name__
    if place.given:
        return f"{kind} has no compiled form: its rows come from its equation, and nothing of it can be set in a loop"
    return f"nothing called {name!r} can be set of {kind} in a loop; {suggest(name, place.numbers)}"


class ControlLoop:
    """The steps of a `VelocityController` with one stack and one length of step: what does not change is prepared.

    A step checks q and targets, computes tasks, limits and joint velocities in one compiled call, and writes the
    velocities into an array; nothing is allocated, looked up or compiled. `report` makes the report of the last step
    when it is asked for. Results are those of the controller.

    What has no compiled form takes part all the same: rows of your own tasks come from their `equation`, motions of
    inverses that are no gain formula from the inverse, collision distances from the scene, and where nothing else
    helps, as for `Reach`, the controller makes the step. `compiled` says whether a step is one compiled call.

    Attributes:
        controller: A controller of its own, which makes the steps that compiled code cannot make; leave it to the loop.
        tasks: The tasks, level by level, whose targets and gains can be set in place.
        compiled: Whether a step is one compiled call.

    Example:
        >>> import numpy as np
        >>> import robust_ik as rik
        >>> robot = rik.load("panda")
        >>> stack = [[rik.FrameTask(robot.pose(robot.rest), gain=5.0)], [rik.PostureTask(robot.rest)]]
        >>> loop = rik.ControlLoop(rik.VelocityController(robot), stack, dt=0.001)
        >>> q, qdot = robot.rest.copy(), np.empty(robot.n)
        >>> for _ in range(2000):
        ...     loop.tasks[0][0].target[2, 3] -= 0.00005
        ...     q += loop.dt * loop.step(q, qdot)
        >>> loop.report.status.name
        'TRACKING'
    """

    def __init__(self, controller: VelocityController, stack: Stack | Task, dt: float) -> None:
        """Prepares the steps of a run that begins at rest.

        Args:
            controller: A controller with the robot, resolver and limits; its own run is not touched.
            stack: The stack of tasks, as for `VelocityController.step`.
            dt: Length of a step, s.

        Raises:
            InputError: An argument is not valid, or a task does not fit the robot.
            FrameNotFoundError: A task names a frame that the robot does not have.
        """
        if not isinstance(controller, VelocityController):
            raise InputError(f"controller must be a VelocityController, got {controller!r}")
        self._dt = checked_parameter("dt", dt, above=0)
        self.controller = VelocityController(
            controller.robot,
            controller.resolver,
            controller.limits,
            length_scale=controller.length_scale,
            calm=controller.calm,
        )
        self._levels: Levels = checked_stack(stack)
        self._program = self.controller.program(self._levels, self.dt)
        alone = self._program is not None and not self.controller.compiled.asks_outside
        whole = self._program is not None and self._program.whole
        self.compiled = whole and alone
        self._run: Callable[..., int] = _not_compiled
        if self._program is not None and whole:
            self._run = self._program.run if alone else self._within_rows
        self._setup = 0 if self._program is None else self._program.setup
        places = [] if self._program is None else self._program.places
        self.tasks = [[LoopTask(place) for place in level] for level in places]
        self.reset()

    @property
    def dt(self) -> float:
        """Length of a step, s."""
        return self._dt

    def __reduce__(self) -> tuple[object, ...]:
        # A copy has memory of its own; what compiled code holds are addresses.
        return ControlLoop, (self.controller, self._present(), self.dt), self._last()

    def __setstate__(self, qdot: Array) -> None:
        self.reset(qdot)

    def _last(self) -> Array:
        """The velocities of the last step, (n,)."""
        return self.controller.qdot if self._program is None else self._program.last

    def reset(self, qdot: ArrayLike | None = None) -> None:
        """Begins a new run, with the targets and gains of the present one.

        Args:
            qdot: Present joint velocities of the robot, (n,); default at rest.
        """
        self.controller.reset(qdot)
        if self._program is not None:
            self.controller.compiled.keep(self._program, self.controller.begun(self.dt), self.controller.calming)
            self._program.begin(self.controller.qdot)
        self._found: Resolution | None = None
        self._rows: Bounds | None = None
        self._unkept: Unkept | None = None

    def step(self, q: Array, out: Array | None = None) -> Array:
        """Joint velocities for the step from q.

        Args:
            q: Configuration, (nq,); contiguous doubles are fastest.
            out: Array for the result, (n,), contiguous doubles; default a new one.

        Returns:
            q̇, (n,), rad/s or m/s: `out` if given.

        Raises:
            InputError: q or a target is not valid, or an array has the wrong shape.
        """
        if out is None:
            out = np.empty(self.controller.robot.n)
        if self._run(self._setup, q, out, BEGIN, 0) == DONE:
            self._found = None
            return out
        return self._otherwise(q, out)

    def runs(
        self,
        q: ArrayLike,
        steps: int,
        *,
        every: int = 1,
        numbers: Mapping[tuple[int, int], Mapping[str, ArrayLike]] | None = None,
        noise: float = 0.0,
        lag: float = 0.0,
        seed: int = 0,
        threads: int = 1,
    ) -> LoopRuns:
        """Many runs from rest with the loop's present targets and gains, by explicit Euler steps.

        The same bits for one run, for many, and on any number of threads. The loop's own run is not touched.

        Args:
            q: Starts, (N, nq).
            steps: Number of steps of every run.
            every: Every how many steps configuration and velocities are recorded.
            numbers: What differs from run to run: by level and place of a task, its attributes as for `tasks`, with a
                leading axis of N: `{(0, 0): {"target": poses}}`.
            noise: Standard deviation of the measurement of every joint value, rad or m.
            lag: Time constant with which the drives follow the velocities asked for, s.
            seed: Of the noise.
            threads: Number of threads; compiled code releases Python's lock.

        Raises:
            InputError: An argument is not valid.
        """
        robot = self.controller.robot
        starts = as_measures(q, "q", (robot.nq,))
        if starts.ndim != 2 or not len(starts):
            raise InputError(f"q must be at least one start, (N, {robot.nq}), got shape {starts.shape}")
        robot.joint_values(starts)
        check_whole("steps", steps, 1)
        check_whole("every", every, 1)
        check_whole("threads", threads, 1)
        check_whole("seed", seed, 0)
        noise, lag = checked_parameter("noise", noise, least=0), checked_parameter("lag", lag, least=0)
        if self._program is None or not self.compiled:
            raise InputError("many runs take a loop that is compiled; this one's rows or motions come from outside")
        places, given = self._varied(numbers or {}, len(starts))
        plan = RunPlan(
            q=starts,
            qdot=np.zeros((len(starts), robot.n)),
            steps=int(steps),
            every=int(every),
            noise=noise,
            share=1.0 if lag == 0.0 else -math.expm1(-self.dt / lag),
            seeds=np.random.default_rng(seed).integers(MOST_SEED, size=len(starts)).astype(float),
            places=places,
            numbers=given,
        )
        return make_runs(self._program, plan, int(threads), partial(self._outside, plan))

    def _varied(self, numbers: Mapping[tuple[int, int], Mapping[str, ArrayLike]], count: int) -> tuple[Array, Array]:
        """Places in the program of what differs from run to run, (P,), and the numbers, (N, P)."""
        places, values = [np.zeros(0)], [np.zeros((count, 0))]
        if not isinstance(numbers, Mapping) or not all(isinstance(each, Mapping) for each in numbers.values()):
            raise InputError(f"numbers must be such as {{(0, 0): {{'target': poses}}}}, got {reprlib.repr(numbers)}")
        for at, attributes in numbers.items():
            try:
                level, index = at
                place: Place = vars(self.tasks[level][index])["_place"]
            except (TypeError, ValueError, IndexError):
                raise InputError(f"numbers are for tasks by level and place, such as (0, 0), got {at!r}") from None
            for name, given in attributes.items():
                if name not in place.numbers:
                    raise InputError(_unknown(place, name))
                view = place.numbers[name]
                array = _checked_numbers(name, given, (count, *view.shape))
                places.append(places_of(view, place.program))
                values.append(array.reshape(count, -1))
        return np.concatenate(places), np.ascontiguousarray(np.concatenate(values, axis=1))

    def _outside(self, plan: RunPlan, run: int, q: Array, last: Array, stopped: Array, noted: Array) -> Array:
        """A step of one of many runs that compiled code has left; what the run remembers is moved on."""
        other = ControlLoop(self.controller, self._present(), self.dt)
        program = other._program
        if program is None:
            raise InputError("a loop that was compiled is not any more")
        program.program[plan.places.astype(int)] = plan.numbers[run]
        program.put_memory(last, stopped, noted)
        out = other._otherwise(q, np.empty(len(last)))
        stopped[:], noted[:] = program.eased, program.noted
        return out

    @property
    def report(self) -> Resolution:
        """The report of the last step; what it says of levels and limits is made when that is read.

        Raises:
            InputError: No step has been made, or the last one was refused.
        """
        if self._found is None and self._program is not None and self._program.made:
            self._found = self.controller.compiled.unread(self._program, self._program.velocities, self._rows)
        if self._found is None:
            raise InputError("there is no report before a step is made, or after one that was refused")
        return self._found

    def _within_rows(self, _setup: int, q: ArrayLike, out: Array, *_: int) -> int:
        """A step in compiled code whose limits are computed outside of it in part. Returns a status."""
        n, robot = len(out) if type(out) is np.ndarray else -1, self.controller.robot
        if self._program is None or not (is_plain(q, robot.nq) and n == robot.n and is_plain(out, n)):
            return UNLIKE
        made = self.controller.compiled.prepared(self._program, q, out)
        self._rows, self._unkept = (made, None) if isinstance(made, Bounds) else (None, made)
        return UNLIKE if self._rows is None else DONE

    def _otherwise(self, q: ArrayLike, out: Array) -> Array:
        """A step by the controller: from other arrays, with rows from outside, or by NumPy; raises what is wrong."""
        checked_out(out, (self.controller.robot.n,))
        self._found = None
        if self._program is not None:
            self._program.made = False
        self._levels = self._present()
        program = self._program
        if program is not None:
            program.keep()
            self.controller.qdot = program.last
        unkept, self._unkept = self._unkept, None
        if unkept is None:
            found = self.controller.step(q, self._levels, self.dt)
        else:
            found = self.controller.finish(as_measures(q, "q", ()), self._levels, self.dt, unkept)
        out[:] = found.qdot
        self._found = found
        if program is not None:
            program.begin(found.qdot)
        return out

    def _present(self) -> Levels:
        """The stack with the present targets and gains."""
        if self._program is None:
            return self._levels
        return tuple(tuple(place.present(self.controller.robot) for place in level) for level in self._program.places)


def _checked_numbers(name: str, given: ArrayLike, shape: tuple[int, ...]) -> Array:
    """What differs from run to run: as for one loop, gains and weights are > 0, and only caps may be infinite."""
    if len(shape) > 1:
        array = as_measures(given, name, shape)
    else:
        array = as_array(given, name, shape, finite=False)
        for value in array.ravel().tolist():
            if not (value == math.inf and name not in FINITE):
                checked_parameter(name, value, above=0)
    if array.shape != shape:
        raise InputError(f"{name} must have shape {shape}, one for each run, got {array.shape}")
    return array


FINITE = ("gain", "weight")
"""Numbers of tasks that may not be infinite, as caps and thresholds may."""


def _not_compiled(*_: object) -> int:
    """Makes no step, so that the controller makes it."""
    return UNLIKE
