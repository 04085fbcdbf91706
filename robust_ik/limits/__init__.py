"""Limits: each gives bounds on q̇ for a robot at q."""

from robust_ik.limits.base import Limit
from robust_ik.limits.collision import CollisionLimit, PairDistance
from robust_ik.limits.collision_pairs import IgnoredPair
from robust_ik.limits.joint import JointLimits
from robust_ik.limits.obstacles import HalfSpace, Obstacle

__all__ = ["CollisionLimit", "HalfSpace", "IgnoredPair", "JointLimits", "Limit", "Obstacle", "PairDistance"]
