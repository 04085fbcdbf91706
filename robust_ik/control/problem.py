"""The problem that a resolver solves, as plain frozen values. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass

from robust_ik.control.bounds import Bounds
from robust_ik.inverses.task_equation import TaskEquation


@dataclass(frozen=True, eq=False)
class VelocityProblem:
    """Levels of task equations, and bounds on q̇.

    Attributes:
        levels: One equation per level, the most important first.
        bounds: Bounds on q̇.
        dt: Duration of q̇, s; 0 if unknown.
        share: The share of what tasks ask for that the levels' ẋ are: less than 1 for an arm that is being calmed.
    """

    levels: tuple[TaskEquation, ...]
    bounds: Bounds
    dt: float = 0.0
    share: float = 1.0
