"""Brings a frame's point to a position; its rotation is free."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_cap, checked_parameter
from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.compiled_form import CompiledForm, Numbers, pose_form
from robust_ik.control.tasks.pose_feedback import capped
from robust_ik.control.tasks.task_arguments import (
    checked_frame,
    checked_selection,
    indices,
    lengths,
    one_configuration,
    one_vector,
    task_rows,
)
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class PositionTask(Task):
    """Bring the point of a frame to a target: ẋ = feedforward + gain · cap(target − p).

    Attributes:
        target: Wanted position in the world, (3,), m.
        gain: Proportional gain, 1/s.
        max_linear: Cap on the error before the gain, m.
        feedforward: Velocity of the target, (3,), m/s, world axes.
        frame: Link or joint; default the robot's tip.
        rows: Of x y z, world axes; default those of the robot's task rows for its tip, all three for another frame.
        weight: See `Task`.
    """

    target: Array
    gain: float = 1.0
    max_linear: float = math.inf
    feedforward: Array = field(default_factory=lambda: np.zeros(3))
    frame: str | None = None
    rows: tuple[str, ...] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        checked_frame("frame", self.frame)
        self._store(
            target=one_vector("target", self.target, 3),
            gain=checked_parameter("gain", self.gain, above=0),
            max_linear=checked_cap("max_linear", self.max_linear),
            feedforward=one_vector("feedforward", self.feedforward, 3),
            rows=checked_selection(self.rows, ROWS[:3]),
        )

    structural = ("frame", "rows")
    numbers: ClassVar[dict[str, Numbers]] = {
        "weight": Numbers(slots.WEIGHT),
        "gain": Numbers(slots.GAIN_OF),
        "max_linear": Numbers(slots.LINEAR),
        "feedforward": Numbers(slots.FORWARD, (3,)),
        "target": Numbers(slots.GOAL + 3, (3,), (4,)),
    }

    def form(self, robot: Robot) -> CompiledForm:
        """See `Task.form`."""
        return pose_form(task_rows(robot, self.frame, self.rows, among=ROWS[:3]), self.frame)

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q; see `Task.equation`."""
        rows = task_rows(robot, self.frame, self.rows, among=ROWS[:3])
        kept = indices(rows)
        one_configuration(q)
        error = (self.target - robot.pose(q, self.frame)[:3, 3])[kept]
        xdot = self.feedforward[kept] + self.gain * capped(error, self.max_linear)
        H = robot.hessian(q, self.frame, rows=rows) if hessian else None
        return TaskEquation(robot.jacobian(q, self.frame, rows=rows), xdot, error, H, self.weight, lengths(rows))
