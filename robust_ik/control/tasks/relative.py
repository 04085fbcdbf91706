"""Brings one frame to a pose relative to another, for two arms that work together."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_cap, checked_parameter
from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.compiled_form import POSE_NUMBERS, CompiledForm, Numbers, pose_form
from robust_ik.control.tasks.frame import one_pose
from robust_ik.control.tasks.pose_difference import cross
from robust_ik.control.tasks.pose_feedback import Feedback, FrameMotion, rotated
from robust_ik.control.tasks.task_arguments import checked_choice, checked_frame, checked_selection, one_vector
from robust_ik.errors import InputError
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot

AXES = ("root axes", "target")


@dataclass(frozen=True, eq=False)
class RelativeTask(Task):
    """Bring a frame to a pose relative to another frame, `root`; both may move.

    T = T_root⁻¹ T_frame. Rows are along the axes of `root` and turn with it, so that a motion of both arms together
    changes nothing.

    Attributes:
        frame: Link or joint.
        root: Link or joint.
        target: Wanted pose of `frame` in `root`, (4, 4).
        gain: Proportional gain, 1/s.
        max_linear: Cap on the position error before the gain, m.
        max_angular: Cap on the rotation error before the gain, rad.
        feedforward: Twist of the target in `root`, (6,), linear then angular, always in the axes of `root`.
        rows: Controlled rows, of x y z wx wy wz; default all six. With two rotations the third is free.
        reference: Axes of the rows: "root axes" or "target".
        weight: See `Task`.
    """

    frame: str
    root: str
    target: Array
    gain: float = 1.0
    max_linear: float = math.inf
    max_angular: float = math.inf
    feedforward: Array = field(default_factory=lambda: np.zeros(6))
    rows: tuple[str, ...] | None = field(default=None, kw_only=True)
    reference: str = field(default="root axes", kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        checked_frame("frame", self.frame, needed=True)
        checked_frame("root", self.root, needed=True)
        if self.frame == self.root:
            raise InputError(f"frame and root must be two frames, got {self.frame!r} twice")
        checked_choice("reference", self.reference, AXES)
        self._store(
            target=one_pose("target", self.target),
            gain=checked_parameter("gain", self.gain, above=0),
            max_linear=checked_cap("max_linear", self.max_linear),
            max_angular=checked_cap("max_angular", self.max_angular),
            feedforward=one_vector("feedforward", self.feedforward, 6),
            rows=checked_selection(self.rows),
        )

    structural = ("frame", "root", "rows", "reference")
    numbers: ClassVar[dict[str, Numbers]] = POSE_NUMBERS

    def form(self, robot: Robot) -> CompiledForm:  # noqa: ARG002
        """See `Task.form`."""
        return pose_form(self.rows or ROWS, self.frame, self.root, along_target=self.reference == "target")

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q; see `Task.equation`."""
        feedback = Feedback(self.gain, self.max_linear, self.max_angular, self.feedforward, self.weight)
        if self.reference == "target":
            feedback = feedback.along(self.target[:3, :3])
        one, other = (FrameMotion.of(robot, q, frame, hessian) for frame in (self.frame, self.root))
        return feedback.equation(relative_motion(one, other), self.target, self.rows or ROWS)


def relative_motion(frame: FrameMotion, root: FrameMotion) -> FrameMotion:
    """The motion of a frame relative to another, in the axes of the other.

    With r = p − p_root: v = Rᵀ(ṗ − ṗ_root + r × ω_root), ω = Rᵀ(ω − ω_root), R the rotation of root.
    """
    R = root.pose[:3, :3].T
    offset, turning = frame.pose[:3, 3] - root.pose[:3, 3], root.J[3:]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = R @ frame.pose[:3, :3], R @ offset
    in_world = frame.J - root.J
    in_world[:3] += cross(offset[:, None], turning)
    if frame.hessian is None or root.hessian is None:
        return FrameMotion(pose, rotated(R, in_world), None)
    H = frame.hessian - root.hessian
    # ∂/∂q_k of r × ω_j: r moves with ∂r/∂q_k, column k of the linear rows.
    H[:3] += cross(offset[:, None, None], root.hessian[3:])
    H[:3] += cross((frame.J - root.J)[:3, None, :], turning[:, :, None])
    # ∂Rᵀ/∂q_k = −Rᵀ [ω_root,k]×.
    for block in (slice(0, 3), slice(3, 6)):
        H[block] -= cross(turning[:, None, :], in_world[block, :, None])
    return FrameMotion(pose, rotated(R, in_world), rotated(R, H))
