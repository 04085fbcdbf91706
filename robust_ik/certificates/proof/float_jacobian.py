"""The Jacobian of an exact arm in floats, for comparison with results in floats. NumPy only."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from robust_ik.certificates.proof.proof import Arm
from robust_ik.checks import Array
from robust_ik.kinematics.twist_rows import ROWS


def float_jacobian(arm: Arm, values: Array) -> Array:
    """The arm's Jacobian in its task rows, at the tip's point, in the base's axes.

    Args:
        arm: The arm.
        values: Joint values, (n,), rad or m.
    """
    place, axes, screws = np.zeros(3), np.eye(3), []
    for joint, link in enumerate(arm.links):
        *rotation, offset = (np.array([float(Fraction(number)) for number in row]) for row in link)
        place, axes = place + axes @ offset, axes @ np.array(rotation)
        if joint == len(arm.joints):
            break
        screws.append((place, axes[:, 2]))
        if joint in arm.sliding:
            place = place + axes[:, 2] * values[joint]
        else:
            c, s = np.cos(values[joint]), np.sin(values[joint])
            axes = axes @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    columns = [
        np.r_[axis, np.zeros(3)] if joint in arm.sliding else np.r_[np.cross(axis, place - origin), axis]
        for joint, (origin, axis) in enumerate(screws)
    ]
    return np.stack(columns, axis=1)[[ROWS.index(row) for row in arm.rows]]
