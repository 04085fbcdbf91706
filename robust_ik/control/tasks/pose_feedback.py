"""Proportional feedback on the pose of a frame, shared by tasks on a pose, a position or a rotation."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array
from robust_ik.control.tasks.pose_difference import error_in_rows
from robust_ik.control.tasks.task_arguments import indices, lengths, one_configuration
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class FrameMotion:
    """Pose, Jacobian and Hessian of a frame, linear rows before angular ones, all in the same axes.

    Attributes:
        pose: (4, 4).
        J: (6, n).
        hessian: ∂J/∂q, (6, n, n), if asked for.
    """

    pose: Array
    J: Array
    hessian: Array | None

    @classmethod
    def of(cls, robot: Robot, q: ArrayLike, frame: str | None, hessian: bool) -> FrameMotion:
        """The motion of a frame in world axes.

        Args:
            robot: The robot.
            q: Configuration, (nq,).
            frame: Link or joint; None for the tip.
            hessian: Whether to compute the Hessian.
        """
        one_configuration(q)
        H = robot.hessian(q, frame, rows=ROWS) if hessian else None
        return cls(robot.pose(q, frame), robot.jacobian(q, frame, rows=ROWS), H)


@dataclass(frozen=True, eq=False)
class Feedback:
    """ẋ = feedforward + gain · capped error.

    Attributes:
        gain: 1/s.
        max_linear: Cap on the position error before the gain, m.
        max_angular: Cap on the rotation error before the gain, rad.
        feedforward: Twist of the target, (6,), in the axes of the motion.
        weight: See `Task`.
        axes: Fixed axes of the rows, the columns of (3, 3); default those of the motion.
    """

    gain: float
    max_linear: float
    max_angular: float
    feedforward: Array
    weight: float
    axes: Array | None = None

    def along(self, axes: Array) -> Feedback:
        """The same feedback with rows along other axes."""
        return replace(self, axes=axes)

    def equation(self, motion: FrameMotion, target: Array, rows: tuple[str, ...]) -> TaskEquation:
        """The rows of J q̇ = ẋ that bring the pose of a motion to a target; the caps apply to these rows only."""
        pose, J, H, feedforward = motion.pose, motion.J, motion.hessian, self.feedforward
        if self.axes is not None:
            R = self.axes.T
            pose, target, J, feedforward = turned(R, pose), turned(R, target), rotated(R, J), rotated(R, feedforward)
            H = None if H is None else rotated(R, H)
        error = error_in_rows(pose, target, rows)
        limited = np.concatenate([capped(error[:3], self.max_linear), capped(error[3:], self.max_angular)])
        xdot = feedforward + self.gain * limited
        if rows == ROWS:
            return TaskEquation(J, xdot, error, H, self.weight, lengths(rows))
        kept, H = indices(rows), None if H is None else H[indices(rows)]
        return TaskEquation(J[kept], xdot[kept], error[kept], H, self.weight, lengths(rows))


def capped(vector: Array, longest: float) -> Array:
    """The vector, no longer than `longest`."""
    if longest == np.inf:
        return vector
    length = float(np.linalg.norm(vector))
    return vector if length <= longest else vector * (longest / length)


def rotated(R: Array, twists: Array) -> Array:
    """Linear and angular rows (6, ...), each rotated by R, (3, 3)."""
    return np.asarray((R @ twists.reshape(2, 3, -1)).reshape(twists.shape))


def turned(R: Array, pose: Array) -> Array:
    """A pose along other axes, (4, 4)."""
    result = pose.copy()
    result[:3] = R @ pose[:3]
    return result
