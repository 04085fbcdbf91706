"""Arms that a floating joint carries: within its limits they are never singular. Arrays only.

The angles of a floating joint have a singular orientation of their own, where its pitch is ±π/2. A search would list it
among the arm's singular configurations. It is none of them, and the limits of the pitch leave it out.
"""

from __future__ import annotations

import numpy as np

from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.singularities.atlas.evidence import Completeness, Evidence
from robust_ik.singularities.conditions.robot_facts import RobotFacts

TRIED = 64
"""Random configurations at which the determinant is compared with the cosine of the pitch.

Chosen: both are polynomials in sines and cosines; where they differ, they differ at nearly every configuration.
"""
AGREES = 1e-9
"""Largest difference of them that is rounding. Chosen: it is below 1e-13 for arms of the catalogue."""
SLIDES, PITCH = 3, 4
"""Number of slides of a floating joint, and place of its pitch, in x, y, z, yaw, pitch, roll."""


def least_determinant(facts: RobotFacts) -> float:
    """The least |det| of the six columns of a floating joint within the limits of its pitch; 0 if that is not shown.

    They have the determinant ± cos(pitch), whatever the other joints do and wherever the tip is. This is tried, not
    believed: where a mimic joint follows one of the six, it need not be so.

    Args:
        facts: Facts of the robot.
    """
    chain = facts.given.in_rows(ROWS)
    if not facts.floating or not set(facts.floating) <= set(chain.joint_names):
        return 0.0
    columns = [chain.joint_names.index(name) for name in facts.floating]
    values = chain.random(np.random.default_rng(0), TRIED)
    J = chain.jacobian(values)[..., columns]
    J[..., :SLIDES] *= chain.length_scale  # lengths in the arm's own unit, in rows and in columns
    ratio = np.abs(np.linalg.det(J)) - np.abs(np.cos(values[:, columns[PITCH]]))
    end = max(-facts.lower[columns[PITCH]], facts.upper[columns[PITCH]])
    if np.abs(ratio).max() > AGREES or not end < np.pi / 2:
        return 0.0
    return float(np.cos(max(end, 0.0)))


def never_singular(facts: RobotFacts, corank: int | None) -> tuple[Evidence, ...]:
    """The evidence that a floating joint keeps an arm from ever being singular; none if it does not.

    Args:
        facts: Facts of the robot.
        corank: The only corank that was asked for, or None for all.
    """
    least = least_determinant(facts)
    if least == 0.0:
        return ()
    pitch, joints = facts.floating[PITCH], f"{facts.floating[0]} to {facts.floating[-1]}"
    words = (
        f"{joints} alone move the tip in all six directions: the determinant of their columns is ± cos {pitch} (at "
        f"{TRIED} random configurations) and at least {least:.3g} within its limits; at {pitch} = ±π/2 it is 0, which "
        "is a singularity of these coordinates, not of the robot"
    )
    return (Evidence(corank or 1, Completeness.NEVER, 0, 0, 0, proof=words),)
