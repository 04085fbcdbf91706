"""Conditions on joint values that make an arm singular: sums of angles, relations fitted to points, their notation."""

from robust_ik.singularities.conditions.angle_sums import wrapped
from robust_ik.singularities.conditions.arm_record import SAME, RobotFacts

__all__ = ["SAME", "RobotFacts", "wrapped"]
