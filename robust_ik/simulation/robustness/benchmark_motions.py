"""The target motions of the benchmark, a pose for every time step: (S + 1, 4, 4)."""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.tasks import pose_error
from robust_ik.kinematics.rotation_vectors import rotations
from robust_ik.kinematics.svd import svd
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot

SETTLE = 0.6
"""Seconds for which a target that has moved stands still, to see what comes to rest."""
FURTHER = 1.6
"""How far a line past the first axis goes, in distances from it at the start."""
TRIED = 200
"""Random configurations of which the least singular one is the start of lines."""
LEAST_DISTANCE = 0.5
"""How far from the first axis the tool is there at least, in length scales."""


def quintic(x: Array) -> Array:
    """From 0 to 1 with no speed and acceleration at both ends, for x from 0 to 1; constant beyond."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x**3 * (10 - 15 * x + 6 * x**2))


def times(seconds: float, dt: float) -> Array:
    """0, dt, … to about `seconds`."""
    return np.asarray(dt * np.arange(round(seconds / dt) + 1), dtype=float)


def as_twist(scaled: Array, rows: tuple[str, ...], length: float) -> Array:
    """A motion in scaled task rows, (m,), as a twist in m and rad, (6,)."""
    twist = np.zeros(6)
    for row, value in zip(rows, scaled):
        twist[ROWS.index(row)] = value * (length if row in ("x", "y", "z") else 1.0)
    return twist


def moved(poses: Array, twists: Array) -> Array:
    """Poses, (..., 4, 4), shifted and turned about world axes by twists in m and rad, (..., 6)."""
    found = np.array(np.broadcast_to(poses, np.broadcast_shapes(poses.shape[:-2], twists.shape[:-1]) + (4, 4)))
    found[..., :3, 3] += twists[..., :3]
    found[..., :3, :3] = rotations(twists[..., 3:]) @ found[..., :3, :3]
    return found


def still(target: Array, seconds: float, dt: float) -> Array:
    """A pose that stands still."""
    return np.broadcast_to(target, (len(times(seconds, dt)), 4, 4))


def crossing(robot: Robot, values: Array, way: Array, shift: Array, seconds: float, dt: float) -> Array:
    """Poses of the arm from half a radian before joint values, along `way`, (n,), to half a radian behind.

    In the middle they are shifted by `shift`, (6,), m and rad, by its half at a quarter and three quarters of the way.
    """
    x = quintic(times(seconds + SETTLE, dt) / seconds)[:, None]
    poses = robot.pose(robot.configuration(values + (2 * x - 1) * 0.5 * way))
    return moved(poses, np.sin(np.pi * x) ** 2 * shift)


def there_and_back(first: Array, last: Array, seconds: float, dt: float) -> Array:
    """Straight from one pose to another and back, in `seconds`."""
    t = times(seconds + SETTLE, dt)
    x = quintic(1 - np.abs(2 * np.minimum(t / seconds, 1.0) - 1))[:, None]
    return moved(first, x * pose_error(first, last))


def regular_start(robot: Robot, length: float, rng: np.random.Generator) -> Array:
    """Joint values with a large σ_min/σ₁ and the tool away from the first axis: the best of some random ones, (n,)."""
    q = robot.random(rng, TRIED)
    units = np.array([length if row in ("x", "y", "z") else 1.0 for row in robot.rows])
    s = svd(robot.jacobian(q) / units[:, None]).s
    away = np.array([_from_first_axis(robot, each)[0] for each in q]) > LEAST_DISTANCE * length
    return np.asarray(robot.joint_values(q[np.argmax(np.where(away, s[:, -1] / s[:, 0], -1.0))]))


def past_the_first_axis(robot: Robot, start: Array, offset: float, seconds: float, dt: float) -> Array:
    """Straight past the first joint's axis and back, the tool's directions kept.

    Args:
        robot: The robot; if its first joint slides, the line is along it.
        start: Joint values, (n,).
        offset: How far the line passes beside the axis, as a share of the distance at the start.
        seconds: There and back.
        dt: Time step, s.
    """
    q = robot.configuration(start)
    distance, radial, sideways = _from_first_axis(robot, q)
    first = robot.pose(q)
    along = -FURTHER * distance * radial
    aside = offset * distance * sideways
    last = moved(first, np.concatenate([along, np.zeros(3)]))
    targets = there_and_back(first, last, seconds, dt)
    share = np.sin(
        np.pi / 2 * np.clip(np.linalg.norm(targets[:, :3, 3] - first[:3, 3], axis=-1) / (0.5 * distance), 0, 1)
    )
    targets[:, :3, 3] += share[:, None] ** 2 * aside
    return targets


def _from_first_axis(robot: Robot, q: Array) -> tuple[float, Array, Array]:
    """How far the tool is from the first axis, m, the direction away from it, and that in which the joint moves it."""
    J = robot.jacobian(q, rows=ROWS)
    moves, axis = J[:3, 0], J[3:, 0]
    distance = float(np.linalg.norm(moves))
    if distance == 0:
        return 0.0, np.eye(3)[0], np.eye(3)[1]
    sideways = moves / distance
    radial = np.cross(sideways, axis) if axis.any() else sideways
    return distance, radial, sideways
