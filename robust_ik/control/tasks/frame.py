"""Brings a frame to a pose: proportional feedback on the pose error, capped, with feed-forward."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_cap, checked_parameter, checked_rigid, readonly
from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.compiled_form import POSE_NUMBERS, CompiledForm, Numbers, pose_form
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
from robust_ik.robot.robot import Robot

AXES = ("world axes", "target")


@dataclass(frozen=True, eq=False)
class FrameTask(Task):
    """Bring a frame to a target pose: ẋ = feedforward + gain · cap(error).

    Caps are on what is asked for. The arm's twist as a whole, rows in their units, is no longer than what is asked for,
    but near singularities and at limits its linear part alone may be faster than gain · max_linear while the tool turns
    more slowly. Within acceleration limits joints cannot slow down at once, and the whole twist may be longer, too, for
    a moment; `Reach` keeps both caps there on its way round.

    To leave the rotation about the tool's z free, for an arm of five joints or a round tool:
    `FrameTask(target, rows=("x", "y", "z", "wx", "wy"), reference="target")`.

    Attributes:
        target: Wanted pose in the world, (4, 4).
        gain: Proportional gain, 1/s.
        max_linear: Cap on the position error before the gain, m.
        max_angular: Cap on the rotation error before the gain, rad.
        feedforward: Twist of the target, (6,), linear then angular, always in world axes.
        frame: Link or joint; default the robot's tip. Several tasks with several frames move several tips of a tree.
        rows: Controlled rows, of x y z wx wy wz; default the robot's task rows for its tip, all six for another
            frame. With two of the three rotations the third is free, and the error is the shortest rotation without it.
        reference: Axes of the rows: "world axes", or "target" for the axes of the target frame, which are constant, so
            that the Hessian is exact too.
        weight: See `Task`.
    """

    target: Array
    gain: float = 1.0
    max_linear: float = math.inf
    max_angular: float = math.inf
    feedforward: Array = field(default_factory=lambda: np.zeros(6))
    frame: str | None = None
    rows: tuple[str, ...] | None = field(default=None, kw_only=True)
    reference: str = field(default="world axes", kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        checked_frame("frame", self.frame)
        checked_choice("reference", self.reference, AXES)
        self._store(
            target=one_pose("target", self.target),
            rows=checked_selection(self.rows),
            feedforward=one_vector("feedforward", self.feedforward, 6),
            gain=checked_parameter("gain", self.gain, above=0),
            max_linear=checked_cap("max_linear", self.max_linear),
            max_angular=checked_cap("max_angular", self.max_angular),
        )

    structural = ("frame", "rows", "reference")
    numbers: ClassVar[dict[str, Numbers]] = POSE_NUMBERS

    def form(self, robot: Robot) -> CompiledForm:
        """See `Task.form`."""
        in_world = self.reference == "world axes"
        rows = task_rows(robot, self.frame, self.rows, world_axes=in_world)
        return pose_form(rows, self.frame, along_target=not in_world)

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q, reference LOCAL_WORLD_ALIGNED or the target's axes; see `Task.equation`."""
        in_world = self.reference == "world axes"
        rows = task_rows(robot, self.frame, self.rows, world_axes=in_world)
        motion = FrameMotion.of(robot, q, self.frame, hessian)
        feedback = Feedback(self.gain, self.max_linear, self.max_angular, self.feedforward, self.weight)
        if in_world:
            return feedback.equation(motion, self.target, rows)
        return feedback.along(self.target[:3, :3]).equation(motion, self.target, rows)


def one_pose(name: str, value: ArrayLike) -> Array:
    """A read-only copy of one rigid pose, (4, 4)."""
    pose = checked_rigid(value, name)
    if pose.ndim != 2:
        raise InputError(f"{name} must be one pose, (4, 4), got shape {pose.shape}")
    return readonly(pose)
