"""Simulates a robot with a stack of tasks within limits, and records the run."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_measures, checked_parameter
from robust_ik.checks.public_arguments import checked
from robust_ik.control.control_loop import ControlLoop
from robust_ik.control.limits import Limit
from robust_ik.control.resolution import Resolution
from robust_ik.control.tasks import Levels, checked_stack
from robust_ik.control.velocity_controller import VelocityController
from robust_ik.errors import InputError
from robust_ik.robot.robot import Robot
from robust_ik.runtime.progress import ProgressCallback, progress_bar
from robust_ik.simulation.run_record import RunRecord
from robust_ik.simulation.scenario import Method, Motion, Scenario
from robust_ik.simulation.trajectory import Trajectory

MAX_STEPS = 10_000_000
"""Most steps of a run.

Chosen: a day of 100 steps a second has 8,640,000; more is a mistake in dt, and would fill memory.
"""


@overload
def simulate(
    robot: Robot,
    resolver: Method | None,
    motion: Motion,
    q0: ArrayLike,
    *,
    duration: float,
    dt: float = 0.01,
    limits: Sequence[Limit] | Limit | None = None,
    length_scale: float | None = None,
    calm: bool = True,
    progress: ProgressCallback | None = None,
) -> Trajectory: ...


@overload
def simulate(robot: Scenario, resolver: Method | str, *, progress: ProgressCallback | None = None) -> Trajectory: ...


@checked
def simulate(
    robot: Robot | Scenario,
    resolver: Method | str | None,
    motion: Motion | None = None,
    q0: ArrayLike | None = None,
    *,
    duration: float | None = None,
    dt: float = 0.01,
    limits: Sequence[Limit] | Limit | None = None,
    length_scale: float | None = None,
    calm: bool = True,
    progress: ProgressCallback | None = None,
) -> Trajectory:
    """Simulates a stack of tasks from q0 on, by explicit Euler steps; or a scenario, which defines all but the method.

    Args:
        robot: The robot; or a `Scenario`, with which only the resolver is given, or the label of one of its methods.
        resolver: A resolver; an inverse stands for `TaskPriority` with it; None for a controller's default.
        motion: A stack of tasks, or a function from time in s to one: `Follow(path)` keeps the tip on a path.
        q0: Start configuration, (nq,).
        duration: Duration of the run, s.
        dt: Time step, s. Feedback is stable for gain · dt < 2 with an inverse that is at most exact.
        limits: As for `VelocityController`: by default the robot's own; () for none.
        length_scale: As for `VelocityController`.
        calm: The same. Scenarios are there to compare methods, and run without.
        progress: Called with (steps done, steps in all); by default a bar is shown in a terminal if the run takes long.

    Raises:
        InputError: A parameter or array is not valid.
        FrameNotFoundError: A task names a frame that the robot does not have.
    """
    if isinstance(robot, Scenario):
        return _run_scenario(robot, resolver, progress)
    if isinstance(resolver, str) or motion is None or q0 is None or duration is None:
        raise InputError("a robot is simulated with a resolver, motion=, q0= and duration=; a Scenario has the rest")
    q = as_measures(q0, "q0", (robot.nq,)).copy()
    if q.ndim != 1:
        raise InputError(f"q0 must be one configuration, got shape {q.shape}")
    steps = _number_of_steps(duration, dt)
    controller = VelocityController(robot, resolver, limits, length_scale=length_scale, calm=calm)
    if progress is None:
        with progress_bar(f"simulating {robot.name}") as told:
            return _run(controller, motion, q, steps, dt, told)
    return _run(controller, motion, q, steps, dt, progress)


def _run_scenario(scenario: Scenario, given: Method | str | None, progress: ProgressCallback | None) -> Trajectory:
    """Runs a scenario with one method; the run of one of its own methods is named by its label."""
    method = scenario.method(given) if isinstance(given, str) else given
    run = simulate(
        scenario.robot, method, scenario.motion, scenario.q0,
        duration=scenario.duration, dt=scenario.dt, limits=scenario.limits, calm=False, progress=progress,
    )  # fmt: skip
    return replace(run, name=given) if isinstance(given, str) else run


def _run(
    controller: VelocityController, motion: Motion, q: Array, steps: int, dt: float, told: ProgressCallback
) -> Trajectory:
    robot, stack = controller.robot, _stack_at(motion, 0.0)
    loop = None if callable(motion) else ControlLoop(controller, stack, dt)
    record = RunRecord(controller if loop is None else loop.controller, steps, dt, stack)
    for i in range(steps):
        started = time.perf_counter()
        resolution = controller.step(q, stack, dt) if loop is None else _step_of(loop, q)
        record.write(time.perf_counter() - started, q, stack, resolution)
        q = robot.integrate(q, dt * resolution.qdot)
        if callable(motion):
            stack = _stack_at(motion, (i + 1) * dt)
        told(i + 1, steps)
    return record.trajectory(q, stack)


def _step_of(loop: ControlLoop, q: Array) -> Resolution:
    """The next step of a loop."""
    loop.step(q)
    return loop.report


def _stack_at(motion: Motion, now: float) -> Levels:
    """The stack at a time; raises if there is a pose instead, since `Follow` is missing then."""
    stack = motion(now) if callable(motion) else motion
    if isinstance(stack, np.ndarray):
        raise InputError("motion must give stacks of tasks; Follow(path) makes them from a path of poses")
    return checked_stack(stack)


def _number_of_steps(duration: float, dt: float) -> int:
    dt, duration = checked_parameter("dt", dt, above=0), checked_parameter("duration", duration, above=0)
    if dt > duration:
        raise InputError(f"dt ≤ duration must hold, got dt={dt!r}, duration={duration!r}")
    steps = round(duration / dt)
    if steps > MAX_STEPS:
        raise InputError(f"{steps} steps are more than {MAX_STEPS}; take a larger dt")
    return steps
