"""Checks what `Robot.plan_path` is given."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_parameter
from robust_ik.errors import InputError
from robust_ik.pose_ik import as_poses
from robust_ik.robot.robot_kinematics import RobotKinematics

ACCURACY, LEAST_ACCURACY = 1e-4, 1e-8
"""How far a tool may leave its path if nothing is said, a tenth of a millimetre for usual arms, and the least that it
may be asked for, in length scales.
"""


def path_arguments(
    robot: RobotKinematics, poses: ArrayLike, q0: ArrayLike, start: ArrayLike | None, accuracy: float | None
) -> tuple[Array, Array, float, Array | None]:
    """Poses (p, 4, 4), joint values (n,) to begin near, the accuracy, m, and joint values (n,) to begin at, if any.

    Raises:
        InputError: One of them is not valid.
    """
    targets = as_poses(poses, robot.length_scale)
    if targets.ndim != 3 or not len(targets):
        raise InputError(f"poses must be (p, 4, 4) or positions (p, 3), got shape {np.shape(poses)}")
    given = ACCURACY * robot.length_scale if accuracy is None else accuracy
    most = checked_parameter("accuracy", given, least=LEAST_ACCURACY * robot.length_scale)
    near, begin = robot.joint_values(q0), None if start is None else robot.joint_values(start)
    if near.ndim != 1 or (begin is not None and begin.ndim != 1):
        raise InputError(f"q0 and start must be one configuration ({robot.nq},) each")
    if begin is not None and not ((begin >= robot.lower) & (begin <= robot.upper)).all():
        raise InputError("start must be within joint limits")
    return targets, near, most, begin
