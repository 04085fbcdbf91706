"""The constants of a screw chain, read off a robot at zero. NumPy only."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors import TipError
from robust_ik.rows import ROWS

if TYPE_CHECKING:
    from robust_ik.robot import Robot


def screws_at_zero(robot: Robot) -> tuple[Array, Array, tuple[bool, ...], Array, Array]:
    """The axes that move a robot's tip, with all independent joints at zero.

    A joint's screw is what it adds to the Jacobian, in the world's reference, of the link that carries it.

    Args:
        robot: Any robot with a tip.

    Returns:
        Unit axes (c, 3), points on them (c, 3), whether they slide, the mixing of independent joints (c, n), and the
        tip's point (3,).

    Raises:
        TipError: The robot was loaded whole, without a tip.
    """
    if robot.tip is None:
        raise TipError(f"{robot.name} was loaded whole, without a tip: singularities are those of a chain to a tip")
    joints = [joint for joint in robot.description.chain(robot.tip) if joint.kind != "fixed"]
    axes, points, mixing = [], [], []
    for joint in joints:
        driver = robot.description.driver[joint.name]
        column = robot.joint_names.index(driver.source)
        mixing.append(driver.multiplier * np.eye(robot.n)[column])
        carrier, moved = (
            robot.jacobian(robot.neutral, link, "world", rows=ROWS)[:, column] for link in (joint.parent, joint.child)
        )
        linear, angular = np.split((moved - carrier) / (driver.multiplier or 1.0), 2)
        axis = linear if joint.kind == "prismatic" else angular
        axes.append(axis if axis.any() else np.array([0.0, 0.0, 1.0]))
        points.append(np.cross(angular, linear))
    sliding = tuple(joint.kind == "prismatic" for joint in joints)
    return np.array(axes), np.array(points), sliding, np.array(mixing), robot.pose(robot.neutral)[:3, 3]


def axis_frames(axes: Array, points: Array, tip: Array) -> tuple[Array, Array, Array]:
    """Each axis as the z of a frame, from one to the next.

    Args:
        axes: Unit vectors, (c, 3).
        points: A point on each, (c, 3).
        tip: The tip's point, (3,).

    Returns:
        Rotations (c, 3, 3) and offsets (c, 3) into the frame before, the first one being the world, and the tip's
        point in the last frame.
    """
    rotation, origin = np.eye(3), np.zeros(3)
    rotations, offsets = [], []
    for axis, point in zip(axes, points):
        frame = _with_z(axis)
        rotations.append(rotation.T @ frame)
        offsets.append(rotation.T @ (point - origin))
        rotation, origin = frame, point
    return np.array(rotations), np.array(offsets), rotation.T @ (tip - origin)


def _with_z(axis: Array) -> Array:
    """A rotation whose third column is a unit axis."""
    x = np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis], axis=-1)


def ranges(robot: Robot, sliding: Array, mixing: Array) -> tuple[Array, Array, Array]:
    """Where to search, and the period of each joint. Limits count for joints that slide only.

    Args:
        robot: The robot.
        sliding: Which of the c joints that move the tip slide.
        mixing: Their motions by the independent joints, (c, n).

    Returns:
        Lower and upper ends, a full turn, or the limits, 2 m where none are stated; and after how much each value
        comes back to the same pose, infinite where it does not, (n,) each.
    """
    used = mixing != 0
    slides = (used & sliding[:, None]).any(axis=0)
    least = np.min(np.where(used, np.abs(mixing), 1.0), axis=0, initial=1.0)
    whole = (np.round(mixing) == mixing).all(axis=0)
    low = np.where(np.isfinite(robot.lower), robot.lower, np.where(np.isfinite(robot.upper), robot.upper - 2, -1.0))
    high = np.where(np.isfinite(robot.upper), robot.upper, low + 2)
    period = np.where(whole & ~slides, 2 * np.pi, np.inf)
    return np.where(slides, low, -np.pi / least), np.where(slides, high, np.pi / least), period
