"""Conditions on joint values for singularity: sums of angles, relations fitted to points, and their notation."""

from robust_ik.singularities.conditions.angle_sums import wrapped
from robust_ik.singularities.conditions.robot_facts import SAME, RobotFacts

__all__ = ["SAME", "RobotFacts", "wrapped"]
