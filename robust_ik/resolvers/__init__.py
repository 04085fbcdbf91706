"""Resolvers: from levels of tasks and bounds to joint velocities."""

from robust_ik.resolvers.base import InverseResolver, Resolver
from robust_ik.resolvers.decoupled import DecoupledPriority
from robust_ik.resolvers.levels import PriorityResolver
from robust_ik.resolvers.limiters import Limiter, QuadraticProgram, Saturation, Scaling, Sliding
from robust_ik.resolvers.priority import TaskPriority
from robust_ik.resolvers.reconstruction import TaskReconstruction
from robust_ik.resolvers.weighted_priority import WeightedPriority

__all__ = [
    "DecoupledPriority",
    "InverseResolver",
    "Limiter",
    "PriorityResolver",
    "QuadraticProgram",
    "Resolver",
    "Saturation",
    "Scaling",
    "Sliding",
    "TaskPriority",
    "TaskReconstruction",
    "WeightedPriority",
]
