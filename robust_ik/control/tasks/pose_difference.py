"""Differences between poses, rotations and directions. Arrays only."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, check_leading_axes, checked_rigid
from robust_ik.kinematics.rotation_vectors import rotation_vector
from robust_ik.kinematics.twist_rows import ROWS


def pose_error(T_world_tool: ArrayLike, T_world_target: ArrayLike) -> Array:
    """The pose error: the difference of positions, and the rotation vector from a pose to its target.

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
    position = target[..., :3, 3] - current[..., :3, 3]
    rotation = rotation_vector(target[..., :3, :3] @ np.swapaxes(current[..., :3, :3], -1, -2))
    return np.concatenate(np.broadcast_arrays(position, rotation), axis=-1)


def error_in_rows(current: Array, target: Array, rows: tuple[str, ...]) -> Array:
    """The pose error in some rows, (6,), zero in the others.

    If two of the three rotations are controlled, the third is free: the error is then the swing, the shortest rotation
    that remains after the free one. The rows of the rotation vector would be turned against it by half the free angle,
    and would lead nowhere if that angle is π.

    Args:
        current: Pose, (4, 4).
        target: Pose, (4, 4).
        rows: Of x y z wx wy wz.
    """
    error = np.zeros(6)
    error[:3] = target[:3, 3] - current[:3, 3]
    angular = [row for row in rows if row in ROWS[3:]]
    if len(angular) == 2:
        turn = target[:3, :3] @ current[:3, :3].T
        free = next(index for index in range(3) if ROWS[3 + index] not in angular)
        error[3:] = swing(turn[free], np.eye(3)[free])
    elif angular:
        error[3:] = rotation_vector(target[:3, :3] @ current[:3, :3].T)
    for index, row in enumerate(ROWS):
        if row not in rows:
            error[index] = 0.0
    return error


def swing(now: Array, wanted: Array) -> Array:
    """The shortest rotation that brings one unit vector to another, (3,), rad: perpendicular to both.

    At π every perpendicular axis is right; one of them is chosen.
    """
    axis = cross(now, wanted)
    sine = math.sqrt(axis @ axis)
    angle = math.atan2(sine, now @ wanted)
    if sine > 1e-12:
        return np.asarray(axis * (angle / sine))
    return angle * perpendicular(wanted)[0] if angle > 1 else axis


def perpendicular(direction: Array) -> Array:
    """Two unit vectors as rows that form a right-handed frame with the given unit vector, (2, 3)."""
    least = np.argmin(np.abs(direction))
    first = -direction[least] * direction
    first[least] += 1
    first /= math.sqrt(first @ first)
    return np.stack([first, cross(direction, first)])


def cross(a: Array, b: Array) -> Array:
    """The cross product along the first axis, (3, ...) and (3, ...); the other axes broadcast."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
