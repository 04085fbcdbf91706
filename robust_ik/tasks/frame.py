"""Bring a frame to a pose: proportional feedback on the pose error, capped, with feed-forward."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import (
    Array,
    as_array,
    check_leading_axes,
    checked_cap,
    checked_parameter,
    checked_rigid,
    readonly,
)
from robust_ik.errors import InputError
from robust_ik.problem import TaskEquation
from robust_ik.robot import Robot
from robust_ik.rows import ROWS


def pose_error(T_world_tool: ArrayLike, T_world_target: ArrayLike) -> Array:
    """The twist that leads from a pose to a target in unit time.

    Args:
        T_world_tool: Current poses, (..., 4, 4).
        T_world_target: Wanted poses, (..., 4, 4), leading axes broadcast.

    Returns:
        (..., 6): position difference in m, then the rotation vector in rad, both in world axes. The rotation angle
        is right up to and including π; at π exactly either of the two opposite axes is right.

    Source: J-PARSE, section VI (with a logarithm that is safe near π).
    """
    current = checked_rigid(T_world_tool, "T_world_tool")
    target = checked_rigid(T_world_target, "T_world_target")
    check_leading_axes("T_world_tool", current.shape[:-2], "T_world_target", target.shape[:-2])
    return _pose_error(current, target)


def _pose_error(current: Array, target: Array) -> Array:
    position = target[..., :3, 3] - current[..., :3, 3]
    turn = target[..., :3, :3] @ np.swapaxes(current[..., :3, :3], -1, -2)
    rotation = rotation_vector(turn)
    return np.concatenate(np.broadcast_arrays(position, rotation), axis=-1)


def rotation_vector(R: Array) -> Array:
    """The logarithm of rotation matrices, (..., 3, 3) → (..., 3), by way of the quaternion of largest component."""
    quaternion = _quaternion(R)
    sine = np.linalg.norm(quaternion[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, quaternion[..., :1])
    small = sine < 1e-9
    factor = np.where(small, 2.0, angle / np.where(small, 1.0, sine))
    return np.asarray(factor * quaternion[..., 1:])


def _quaternion(R: Array) -> Array:
    """Unit quaternions (w, x, y, z) with w ≥ 0; the row with the largest pivot keeps every digit."""
    xx, yy, zz = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    wx, wy, wz = R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]
    xy, xz, yz = R[..., 0, 1] + R[..., 1, 0], R[..., 0, 2] + R[..., 2, 0], R[..., 1, 2] + R[..., 2, 1]
    # Row i is 4 q_i (w, x, y, z).
    rows = np.stack(
        [
            np.stack([1 + xx + yy + zz, wx, wy, wz], axis=-1),
            np.stack([wx, 1 + xx - yy - zz, xy, xz], axis=-1),
            np.stack([wy, xy, 1 - xx + yy - zz, yz], axis=-1),
            np.stack([wz, xz, yz, 1 - xx - yy + zz], axis=-1),
        ],
        axis=-2,
    )
    pivot = np.argmax(np.diagonal(rows, axis1=-2, axis2=-1), axis=-1)
    row = np.take_along_axis(rows, pivot[..., None, None], axis=-2)[..., 0, :]
    row = row / np.linalg.norm(row, axis=-1, keepdims=True)
    return np.asarray(np.where(row[..., :1] < 0, -row, row))


@dataclass(frozen=True, eq=False)
class FrameTask:
    """Bring a frame to a target pose: ẋ = feedforward + cap(gain · error).

    Attributes:
        target: Wanted pose in the world, (4, 4).
        gain: Proportional gain, 1/s.
        max_linear: Cap on the position error before the gain, m.
        max_angular: Cap on the rotation error before the gain, rad.
        feedforward: Twist of the target, (6,), linear then angular, world axes.
        frame: Link or joint; default the robot's tip.
    """

    target: Array
    gain: float = 1.0
    max_linear: float = math.inf
    max_angular: float = math.inf
    feedforward: Array = field(default_factory=lambda: np.zeros(6))
    frame: str | None = None

    def __post_init__(self) -> None:
        target = checked_rigid(self.target, "target")
        if target.ndim != 2:
            raise InputError(f"target must be one pose, (4, 4), got shape {target.shape}")
        checked_parameter("gain", self.gain, above=0)
        checked_cap("max_linear", self.max_linear)
        checked_cap("max_angular", self.max_angular)
        object.__setattr__(self, "target", readonly(target))
        object.__setattr__(self, "feedforward", _one_twist(self.feedforward))

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q, in the robot's task rows, reference LOCAL_WORLD_ALIGNED; with the Hessian if asked for."""
        rows = [ROWS.index(row) for row in robot.rows]
        error = np.zeros(6)
        error[rows] = _pose_error(robot.pose(q, self.frame), self.target)[rows]
        capped = np.concatenate([_capped(error[:3], self.max_linear), _capped(error[3:], self.max_angular)])
        xdot = self.feedforward + self.gain * capped
        H = robot.hessian(q, self.frame) if hessian else None
        return TaskEquation(robot.jacobian(q, self.frame), xdot[rows], error[rows], H)


def _one_twist(value: ArrayLike) -> Array:
    twist = as_array(value, "feedforward", (6,))
    if twist.ndim != 1:
        raise InputError(f"feedforward must be one twist, (6,), got shape {twist.shape}")
    return readonly(twist)


def _capped(vector: Array, longest: float) -> Array:
    length = float(np.linalg.norm(vector))
    return vector if length <= longest else vector * (longest / length)
