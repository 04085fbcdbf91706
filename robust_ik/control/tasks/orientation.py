"""Turns a frame to an orientation; its position is free."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_measures, checked_cap, checked_parameter, checked_rigid, readonly
from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.compiled_form import CompiledForm, Numbers, pose_form
from robust_ik.control.tasks.frame import AXES
from robust_ik.control.tasks.pose_feedback import Feedback, FrameMotion
from robust_ik.control.tasks.task_arguments import (
    checked_choice,
    checked_frame,
    checked_selection,
    one_vector,
    task_rows,
)
from robust_ik.errors import InputError
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class OrientationTask(Task):
    """Turn a frame to a target orientation: ẋ = feedforward + gain · cap(rotation vector to the target).

    Attributes:
        target: Wanted rotation, frame to world, (3, 3).
        gain: Proportional gain, 1/s.
        max_angular: Cap on the rotation error before the gain, rad.
        feedforward: Angular velocity of the target, (3,), rad/s, always in world axes.
        frame: Link or joint; default the robot's tip.
        rows: Of wx wy wz; default those of the robot's task rows for its tip, all three for another frame. With two,
            the rotation about the third axis is free.
        reference: Axes of the rows: "world axes" or "target".
        weight: See `Task`.
    """

    target: Array
    gain: float = 1.0
    max_angular: float = math.inf
    feedforward: Array = field(default_factory=lambda: np.zeros(3))
    frame: str | None = None
    rows: tuple[str, ...] | None = field(default=None, kw_only=True)
    reference: str = field(default="world axes", kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        checked_frame("frame", self.frame)
        checked_choice("reference", self.reference, AXES)
        self._store(
            target=one_rotation("target", self.target),
            gain=checked_parameter("gain", self.gain, above=0),
            max_angular=checked_cap("max_angular", self.max_angular),
            feedforward=one_vector("feedforward", self.feedforward, 3),
            rows=checked_selection(self.rows, ROWS[3:]),
        )

    structural = ("frame", "rows", "reference")
    numbers: ClassVar[dict[str, Numbers]] = {
        "weight": Numbers(slots.WEIGHT),
        "gain": Numbers(slots.GAIN_OF),
        "max_angular": Numbers(slots.ANGULAR),
        "feedforward": Numbers(slots.FORWARD + 3, (3,)),
        "target": Numbers(slots.GOAL, (3, 3), (4, 1)),
    }

    def form(self, robot: Robot) -> CompiledForm:
        """See `Task.form`."""
        in_world = self.reference == "world axes"
        rows = task_rows(robot, self.frame, self.rows, among=ROWS[3:], world_axes=in_world)
        return pose_form(rows, self.frame, along_target=not in_world)

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q; see `Task.equation`."""
        in_world = self.reference == "world axes"
        rows = task_rows(robot, self.frame, self.rows, among=ROWS[3:], world_axes=in_world)
        target = np.eye(4)
        target[:3, :3] = self.target
        feedforward = np.concatenate([np.zeros(3), self.feedforward])
        feedback = Feedback(self.gain, math.inf, self.max_angular, feedforward, self.weight)
        if not in_world:
            feedback = feedback.along(self.target)
        return feedback.equation(FrameMotion.of(robot, q, self.frame, hessian), target, rows)


def one_rotation(name: str, value: ArrayLike) -> Array:
    """A read-only copy of one rotation matrix, (3, 3).

    Raises:
        InputError: It is not one.
    """
    matrix = as_measures(value, name, (3, 3))
    if matrix.ndim != 2:
        raise InputError(f"{name} must be one rotation, (3, 3), got shape {matrix.shape}")
    pose = np.eye(4)
    pose[:3, :3] = matrix
    return readonly(checked_rigid(pose, name)[:3, :3])
