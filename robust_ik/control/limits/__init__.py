"""Limits: each gives bounds on q̇ for a robot at q."""

from robust_ik.control.limits.base import Limit, checked_limits
from robust_ik.control.limits.collision_limit import CollisionLimit, PairDistance
from robust_ik.control.limits.collision_pairs import IgnoredPair
from robust_ik.control.limits.joint_limits import JointLimits
from robust_ik.control.limits.obstacles import HalfSpace, Obstacle

__all__ = [
    "CollisionLimit",
    "HalfSpace",
    "IgnoredPair",
    "JointLimits",
    "Limit",
    "Obstacle",
    "PairDistance",
    "checked_limits",
]
