"""The Jacobian of an exact arm in floats, for comparison with results in floats. NumPy only."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from robust_ik.certificates.proof.proof_arm import Arm
from robust_ik.checks import Array
from robust_ik.kinematics.twist_rows import ROWS


def float_jacobian(arm: Arm, values: Array) -> Array:
    """The arm's Jacobian in its task rows, at the tip's point, in the base's axes.

    Args:
        arm: The arm.
        values: Joint values, (n,), rad or m.
    """
    place, axes, screws = np.zeros(3), np.eye(3), []
    motions = [(joint, float(Fraction(factor))) for joint, factor in arm.motions]
    for link, (joint, factor) in zip(arm.links, [*motions, (-1, 0.0)]):
        *rotation, offset = (np.array([float(Fraction(number)) for number in row]) for row in link)
        place, axes = place + axes @ offset, axes @ np.array(rotation)
        if joint < 0:
            break
        screws.append((place, axes[:, 2]))
        if joint in arm.sliding:
            place = place + axes[:, 2] * values[joint] * factor
        else:
            c, s = np.cos(factor * values[joint]), np.sin(factor * values[joint])
            axes = axes @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    J = np.zeros((len(ROWS), len(arm.joints)))
    for (joint, factor), (origin, axis) in zip(motions, screws):
        twist = np.r_[axis, np.zeros(3)] if joint in arm.sliding else np.r_[np.cross(axis, place - origin), axis]
        J[:, joint] += factor * twist
    return J[[ROWS.index(row) for row in arm.rows]]
