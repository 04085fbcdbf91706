"""How far poses are from those of a path, in the wanted rows. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.rotation_vectors import rotation_vector
from robust_ik.kinematics.twist_rows import ROWS


def path_twist(poses: Array, targets: Array, rows: Sequence[str]) -> Array:
    """The motion from poses to targets in rows, (..., 4, 4) and (..., 4, 4) → (..., m), m and rad in world axes.

    With two rotations wanted the frame may turn about the third world axis: the rotation is the shortest one that
    brings that axis, as the frame sees it at the target, into place.
    """
    places = [i for i, row in enumerate(ROWS[:3]) if row in rows]
    turns = [i for i, row in enumerate(ROWS[3:]) if row in rows]
    step = (targets - poses)[..., places, 3]
    if not turns:
        return np.asarray(step)
    D = targets[..., :3, :3] @ np.swapaxes(poses[..., :3, :3], -1, -2)
    if len(turns) == 2:
        (free,) = {0, 1, 2} - set(turns)
        axis = D[..., free, :]  # where the pose has the axis that shall be `free`
        sine = np.cross(axis, np.eye(3)[free])
        size = np.linalg.norm(sine, axis=-1, keepdims=True)
        angle = np.arctan2(size, axis[..., free, None])
        turn = sine * np.where(size > 0, angle / np.where(size > 0, size, 1.0), 0.0)
        opposite = (size == 0)[..., 0] & (axis[..., free] < 0)  # half a turn about any axis across
        turn[..., turns[0]] = np.where(opposite, np.pi, turn[..., turns[0]])
    else:
        turn = rotation_vector(D)
    return np.concatenate([step, turn[..., turns]], axis=-1)


def path_error(poses: Array, targets: Array, rows: Sequence[str], length_scale: float) -> Array:
    """The larger one of the distance, m, and the angle times the length scale, (..., 4, 4) and (..., 4, 4) → (...)."""
    twist, count = path_twist(poses, targets, rows), sum(row in ROWS[:3] for row in rows)
    turn = length_scale * np.linalg.norm(twist[..., count:], axis=-1)
    return np.asarray(np.maximum(np.linalg.norm(twist[..., :count], axis=-1), turn))
