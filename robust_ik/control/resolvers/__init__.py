"""Resolvers: from levels of tasks and bounds to joint velocities."""

from robust_ik.control.resolvers.base import InverseResolver, Resolver
from robust_ik.control.resolvers.classical_projections import LeakingPriority
from robust_ik.control.resolvers.decoupled_priority import DecoupledPriority
from robust_ik.control.resolvers.priority_resolver import PriorityResolver
from robust_ik.control.resolvers.task_priority import TaskPriority
from robust_ik.control.resolvers.task_reconstruction import TaskReconstruction
from robust_ik.control.resolvers.weighted_priority import WeightedPriority
from robust_ik.control.within_bounds.limiters import Limiter, QuadraticProgram, Saturation, Scaling, Sliding

__all__ = [
    "DecoupledPriority",
    "InverseResolver",
    "LeakingPriority",
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
