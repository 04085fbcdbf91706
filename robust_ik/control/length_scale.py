"""Chooses the unit of length in which a robot's Jacobian is inverted."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from robust_ik.checks import checked_parameter
from robust_ik.inverses import SDLS, RobustInverse, Weighted
from robust_ik.robot.robot import Robot


def chosen_length_scale(robot: Robot, inverses: Iterable[RobustInverse], given: float | None) -> float:
    """The length scale that is given; else 1 m if an inverse has row weights of its own, else the robot's."""
    if given is not None:
        return checked_parameter("length_scale", given, above=0)
    return 1.0 if any(has_own_scale(each) for each in inverses) else robot.length_scale


def has_own_scale(inverse: RobustInverse) -> bool:
    """Whether an inverse, or one that it wraps, has its own weights of metres against radians."""
    if isinstance(inverse, Weighted) and (inverse.task_weights is not None or inverse.length_scale is not None):
        return True
    if isinstance(inverse, SDLS) and inverse.length_scale != 1.0:
        return True
    wrapped = getattr(inverse, "inverse", None)
    return isinstance(wrapped, RobustInverse) and has_own_scale(wrapped)


def in_units(inverse: RobustInverse, robot: Robot, rows: tuple[str, ...], length_scale: float) -> RobustInverse:
    """The inverse in a unit of length: itself for 1 m, else wrapped to divide rows in metres and slides by it."""
    if length_scale == 1.0:
        return inverse
    rows_in_metres = np.array([row in ("x", "y", "z") for row in rows])
    joints = np.where(robot.sliding, length_scale**-2.0, 1.0) if robot.sliding.any() else None
    return Weighted(inverse, task_weights=np.where(rows_in_metres, 1 / length_scale, 1.0), joint_weights=joints)
