"""Runs a robot along a path with an inverse, and records everything."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_parameter, readonly
from robust_ik.controller import Posture, VelocityController
from robust_ik.errors import InputError
from robust_ik.inverses import RobustInverse
from robust_ik.linalg import null_projector, svd
from robust_ik.paths import Path
from robust_ik.robot import Robot
from robust_ik.rows import ROWS
from robust_ik.tasks import FrameTask, pose_error

MAX_STEPS = 10_000_000


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A recorded run of N steps; row i of every array belongs to time[i], before step i is taken.

    Attributes:
        robot: The robot that ran.
        inverse: The inverse that drove it.
        time: Seconds, (N,).
        q: Configurations, (N, nq).
        qdot: Commanded joint velocities, (N, n).
        target: Target poses, (N, 4, 4).
        pose: Tip poses, (N, 4, 4).
        error: Target minus tip, (N, 6): m, then rad, world axes; zero in rows that the task does not have.
        sigma: Singular values of the task Jacobian, (N, k), descending.
        seconds_per_step: Median wall-clock time of one control step.
        final_q: Configuration after the last step, (nq,).
        final_error: Target minus tip there, (6,).
    """

    robot: Robot
    inverse: RobustInverse
    time: Array
    q: Array
    qdot: Array
    target: Array
    pose: Array
    error: Array
    sigma: Array
    seconds_per_step: float
    final_q: Array
    final_error: Array

    @property
    def largest_speed(self) -> float:
        """Largest |q̇| of any joint, rad/s or m/s."""
        return float(np.abs(self.qdot).max())

    @property
    def largest_speed_ratio(self) -> float:
        """Largest |q̇| of any joint over its own speed limit; 0 where no limit is stated."""
        return float((np.abs(self.qdot) / self.robot.velocity_limit).max())

    @property
    def position_error(self) -> Array:
        """Distance from the target, (N,), m."""
        return np.asarray(np.linalg.norm(self.error[:, :3], axis=-1))

    @property
    def rotation_error(self) -> Array:
        """Angle from the target, (N,), rad."""
        return np.asarray(np.linalg.norm(self.error[:, 3:], axis=-1))

    @property
    def smallest_sigma(self) -> float:
        """The smallest singular value met."""
        return float(self.sigma[:, -1].min())


def simulate(
    robot: Robot,
    inverse: RobustInverse,
    path: Path,
    q0: ArrayLike,
    *,
    duration: float,
    dt: float = 0.01,
    gain: float = 1.0,
    max_linear: float = np.inf,
    max_angular: float = np.inf,
    posture: Posture | None = None,
    projector: Callable[[ArrayLike], Array] = null_projector,
    progress: Callable[[int, int], None] | None = None,
) -> Trajectory:
    """Follows a moving target with proportional feedback, explicit Euler, no joint limits.

    Args:
        robot: The robot.
        inverse: The robust inverse.
        path: Function from time in s to the wanted pose, (4, 4).
        q0: Configuration to start from, (nq,).
        duration: Seconds to run.
        dt: Time step, s.
        gain: Proportional gain, 1/s; stable for gain · dt < 2 with an inverse that is at most exact.
        max_linear: Cap on the position error, m.
        max_angular: Cap on the rotation error, rad.
        posture: What to do with redundancy.
        projector: From J to the projector of the posture's motion; see `VelocityController`.
        progress: Called with (steps done, steps in all).

    Raises:
        InputError: A parameter or array cannot be meant.
        TipError: The robot has no tip.
    """
    q = as_array(q0, "q0", (robot.nq,)).copy()
    if q.ndim != 1:
        raise InputError(f"q0 must be one configuration, got shape {q.shape}")
    steps = _number_of_steps(duration, dt)
    if not callable(path):
        raise InputError(f"path must be a function from seconds to a pose, got {type(path).__name__}")
    controller = VelocityController(robot, inverse, posture, dt, projector)
    rows = [ROWS.index(row) for row in robot.rows]
    record = _Record(steps, robot)
    for i in range(steps):
        target = path(i * dt)
        task = FrameTask(target, gain=gain, max_linear=max_linear, max_angular=max_angular)
        started = time.perf_counter()
        resolution = controller.step(q, task)
        record.seconds[i] = time.perf_counter() - started
        record.write(i, i * dt, q, resolution.qdot, target, rows)
        q = robot.integrate(q, dt * resolution.qdot)
        if progress is not None:
            progress(i + 1, steps)
    return record.trajectory(robot, inverse, q, path(steps * dt), rows)


def _number_of_steps(duration: float, dt: float) -> int:
    dt, duration = checked_parameter("dt", dt, above=0), checked_parameter("duration", duration, above=0)
    if dt > duration:
        raise InputError(f"dt ≤ duration must hold, got dt={dt!r}, duration={duration!r}")
    steps = round(duration / dt)
    if steps > MAX_STEPS:
        raise InputError(f"{steps} steps are more than {MAX_STEPS}; take a larger dt")
    return steps


class _Record:
    """Arrays that fill up while the simulation runs."""

    def __init__(self, steps: int, robot: Robot) -> None:
        self.robot = robot
        self.time, self.seconds = np.empty(steps), np.empty(steps)
        self.q, self.qdot = np.empty((steps, robot.nq)), np.empty((steps, robot.n))
        self.target, self.pose = np.empty((steps, 4, 4)), np.empty((steps, 4, 4))
        self.error = np.zeros((steps, 6))
        self.sigma = np.empty((steps, min(len(robot.rows), robot.n)))

    def write(self, i: int, now: float, q: Array, qdot: Array, target: Array, rows: list[int]) -> None:
        self.time[i], self.q[i], self.qdot[i], self.target[i] = now, q, qdot, target
        self.pose[i] = self.robot.pose(q)
        self.error[i, rows] = pose_error(self.pose[i], target)[rows]
        self.sigma[i] = svd(self.robot.jacobian(q)).s

    def trajectory(self, robot: Robot, inverse: RobustInverse, q: Array, target: Array, rows: list[int]) -> Trajectory:
        final = np.zeros(6)
        final[rows] = pose_error(robot.pose(q), target)[rows]
        arrays = {
            name: readonly(getattr(self, name)) for name in ("time", "q", "qdot", "target", "pose", "error", "sigma")
        }
        return Trajectory(
            robot=robot,
            inverse=inverse,
            **arrays,
            seconds_per_step=float(np.median(self.seconds)),
            final_q=readonly(q),
            final_error=readonly(final),
        )
