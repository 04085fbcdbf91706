"""The record of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.checks.public_arguments import checked
from robust_ik.control.resolution import Status
from robust_ik.control.resolvers import Resolver
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A recorded run of N steps; row i of every array belongs to time[i], before step i is taken.

    Poses and errors are those of the frame of the stack's first task with a target pose, else of the robot's tip. L is
    the largest number of levels; entries of levels that a step does not have are NaN.

    Attributes:
        robot: The robot.
        resolver: The resolver.
        name: Name of the run: the inverse if it is the same for every level, else the resolver.
        time: Seconds, (N,).
        q: Configurations, (N, nq).
        qdot: Commanded joint velocities, (N, n).
        target: Target poses, (N, 4, 4); the pose itself if there is none.
        pose: Poses of the frame, (N, 4, 4).
        error: Target minus pose, (N, 6): m, then rad, world axes; zero in rows that the task does not have.
        sigma: Singular values of the frame's Jacobian in the robot's rows, (N, k), descending.
        scale: The share of its motion that limits allow each level, (N, L).
        residual: ‖ẋ − J q̇‖ of each level, (N, L).
        manipulability: Π σ of each level in the freedom left by the levels above, (N, L).
        smallest_level_sigma: The smallest σ of each level in the freedom left by the levels above, (N, L).
        corank: How many of these σ are zero, (N, L).
        algorithmic: Whether an algorithmic singularity is near, (N, L).
        calmed: The share of their velocities that tasks asked for in each step, (N,): less than 1 while the arm is
            being calmed, see `Resolution.calmed`.
        status: Status of each step, (N,) of `Status`.
        active: Limits that each step's velocities lie on, N tuples of names.
        contradictions: Limits that yielded in each step, N tuples of names.
        seconds_per_step: Median wall-clock time of one control step.
        final_q: Configuration after the last step, (nq,).
        final_error: Target minus pose at final_q, (6,).
    """

    robot: Robot
    resolver: Resolver
    name: str
    time: Array
    q: Array
    qdot: Array
    target: Array
    pose: Array
    error: Array
    sigma: Array
    scale: Array
    residual: Array
    manipulability: Array
    smallest_level_sigma: Array
    corank: Array
    algorithmic: Array
    calmed: Array
    status: NDArray[Any]
    active: tuple[tuple[str, ...], ...]
    contradictions: tuple[tuple[str, ...], ...]
    seconds_per_step: float
    final_q: Array
    final_error: Array

    def __repr__(self) -> str:
        off = 1000 * float(np.linalg.norm(self.final_error[:3]))
        return f"Trajectory({self.name!r}, {self.robot.name}, {len(self.time)} steps, at the end off by {off:.3g} mm)"

    def __setstate__(self, state: dict[str, Any]) -> None:
        # Arrays that come from another process are writable.
        for value in state.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
        vars(self).update(state)

    @property
    def largest_speed(self) -> float:
        """Largest |q̇| of any joint, rad/s or m/s."""
        return float(np.abs(self.qdot).max())

    @property
    def largest_speed_ratio(self) -> float:
        """Largest |q̇| of any joint divided by its speed limit; 0 if no limit is stated."""
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.abs(self.qdot) / self.robot.velocity_limit
        return float(np.nan_to_num(ratio, nan=0.0, posinf=np.inf).max())

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
        """The smallest singular value of the frame's Jacobian during the run."""
        return float(self.sigma[:, -1].min())

    @checked
    def share(self, status: Status) -> float:
        """The fraction of steps with this status."""
        return float(np.mean([each is status for each in self.status]))
