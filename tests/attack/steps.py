"""Control steps over frames anywhere in any robot: finite, silent, within limits, whatever resolver and inverse."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import robust_ik as rik
from robust_ik.description.catalog import catalog
from tests import soak
from tests.cases_filters import CASES
from tests.cases_others import OTHER_CASES

COUNTS = {"short": 1_000, "full": 1_000_000}
CHUNK = 20_000
LIMITED = False
ROBOTS = 6
"""Robots that a seed takes from all that there are."""
RUN = 5
"""Steps of a run."""
RUNS = 4
"""Runs with one resolver and stack, from other starts."""
NEARLY = (0.0, 1e-17, 1e-15, 1e-13, 1e-10, 1e-7)
"""How far joints are from the angles of a start, rad or m."""
LIMITERS: tuple[rik.Limiter, ...] = (
    rik.Sliding(),
    rik.Sliding(),
    rik.Saturation(),
    rik.Scaling(),
    rik.Scaling(),
    rik.QuadraticProgram(),
    rik.QuadraticProgram(keep_direction=True),
)
Rng = np.random.Generator


def any_resolver(rng: Rng) -> rik.Resolver:
    """With any inverse, or one for each level."""
    inverses: list[Any] = [*CASES, *OTHER_CASES]
    chosen = [inverses[i] for i in rng.integers(len(inverses), size=int(rng.integers(1, 4)))]
    limiter = LIMITERS[rng.integers(len(LIMITERS))]
    release = float(rng.choice([0.0, 0.0, 1e-3]))
    match rng.integers(10):
        case 0:
            return rik.WeightedPriority(chosen)
        case 1 | 2:
            return rik.DecoupledPriority(chosen, limiter, release)
        case 3:
            return rik.TaskReconstruction([CASES[rng.integers(len(CASES))]], limiter)
        case _:
            return rik.TaskPriority(chosen, limiter, release)


def any_rows(rng: Rng, among: tuple[str, ...]) -> tuple[str, ...] | None:
    """Some of the rows, or all that the robot has."""
    kept = tuple(row for row in among if rng.random() < 0.6)
    return kept if kept and rng.random() < 0.5 else None


def any_task(robot: rik.Robot, rng: Rng) -> rik.Task:
    """A task of a frame anywhere, its target near, far, or where it is."""
    frame, other = (robot.frames[i] for i in rng.integers(len(robot.frames), size=2))
    target = robot.pose(robot.random(rng), frame)
    target[:3, 3] *= rng.choice([1.0, 1.0, 10.0])
    gain, joints = float(rng.choice([0.5, 5.0, 100.0])), rng.permutation(robot.joint_names)[: int(rng.integers(1, 3))]
    linear, angular = any_rows(rng, ("x", "y", "z")), any_rows(rng, ("wx", "wy", "wz"))
    match rng.integers(12):
        case 0 | 1 | 2:
            return rik.PositionTask(target[:3, 3], gain, frame=frame, rows=linear)
        case 3:
            return rik.OrientationTask(target[:3, :3], gain, frame=frame, rows=angular)
        case 4 | 5:
            kind = rik.Reach if linear else rik.FrameTask
            return kind(target, gain, frame=frame, rows=any_rows(rng, ("x", "y", "z", "wx", "wy", "wz")))
        case 6:
            return rik.TwistTask(rng.normal(size=6) * rng.choice([1e-9, 0.1, 100.0]), frame=frame)
        case 7:
            return rik.DirectionTask(target[:3, 0], target[:3, 1], gain, frame=frame)
        case 8 if frame != other:
            return rik.RelativeTask(frame, other, target, gain)
        case 9:
            return rik.JointTask(list(joints), [0.1] * len(joints), gain)
        case 10:
            return rik.DampingTask(joints=tuple(joints))
        case _:
            climbing = rik.ManipulabilityTask if rng.random() < 0.5 else rik.SingularValueTask
            return climbing(frame=frame)


def fitting_task(robot: rik.Robot, rng: Rng) -> rik.Task:
    """A task that a robot of few rows does not refuse, as an arm that only moves a point does one of orientation."""
    while True:
        task = any_task(robot, rng)
        try:
            task.equation(robot, robot.rest, hessian=False)
        except rik.InputError:
            if len(robot.rows) == 6:
                raise
        else:
            return task


def any_stack(robot: rik.Robot, rng: Rng) -> list[list[rik.Task]]:
    """One to three levels of one or two tasks."""
    return [
        [fitting_task(robot, rng) for _ in range(int(rng.integers(1, 3)))]
        for _ in range(int(rng.choice([1, 1, 2, 3])))
    ]  # fmt: skip


def any_start(robot: rik.Robot, limits: rik.JointLimits, rng: Rng) -> NDArray[np.float64]:
    """At limits, outside them, at right angles, at rest, exactly or nearly."""
    values = robot.joint_values(soak.random_start(robot, limits, rng))
    moved = values + rng.choice(NEARLY) * rng.normal(size=robot.n)
    return robot.configuration(moved if rng.random() < 0.2 else np.clip(moved, limits.lower, limits.upper))


def free_run(robot: rik.Robot, resolver: rik.Resolver, q: NDArray[np.float64], stack: Any, dt: float) -> None:
    """Without limits: every velocity finite."""
    controller = rik.VelocityController(robot, resolver, ())
    for _ in range(RUN):
        step = controller.step(q, stack, dt)
        assert np.isfinite(step.qdot).all(), "not finite"
        assert all(np.isfinite(level.residual).all() and 0 <= level.scale <= 1 for level in step.levels), "levels"
        q = robot.integrate(q, np.clip(dt * step.qdot, -1.0, 1.0))


def one_setting(robot: rik.Robot, rng: Rng) -> None:
    """RUNS runs of RUN steps; raises at the first broken promise."""
    resolver, stack, limits = any_resolver(rng), any_stack(robot, rng), soak.random_limits(robot, rng)
    free = rng.random() < 0.25
    for _ in range(RUNS):
        q = any_start(robot, limits, rng)
        if free:
            free_run(robot, resolver, q, stack, 0.01)
        else:
            list(soak.kept_run(robot, rng, limits, None, resolver, q, stack, RUN))


def some_robots(rng: Rng) -> list[rik.Robot]:
    """From the whole catalogue, each with the tip that it has without being asked."""
    names = sorted(catalog())
    robots = []
    for name in rng.permutation(names).tolist():
        try:
            robots.append(rik.load(name))
        except rik.RobustIKError:
            continue  # one that needs to be told its tip
        if len(robots) == ROBOTS:
            break
    return robots


def attack(count: int, seed: int, say: Callable[[str], None]) -> list[str]:
    """Takes `count` steps.

    Args:
        count: How many.
        seed: Of the random numbers.
        say: Takes lines about how far it is.

    Returns:
        What failed, a sentence each, with the seed of the setting.
    """
    robots, failures = some_robots(np.random.default_rng(seed)), []
    settings = max(1, count // (RUN * RUNS))
    for index in range(settings):
        robot = robots[index % len(robots)]
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                one_setting(robot, np.random.default_rng([seed, index]))
            except Exception as error:
                failures.append(f"{robot.name}, setting {index} of seed {seed}: {type(error).__name__}: {error}")
        if index % 100 == 99:
            say(f"{(index + 1) * RUN * RUNS} of {count} steps, {len(failures)} failures")
    return failures
