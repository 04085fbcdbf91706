"""What passes from tasks and limits to a resolver: plain frozen values, arrays only."""

from __future__ import annotations

from dataclasses import dataclass

from robust_ik.control.bounds import Bounds
from robust_ik.inverses.task_equation import TaskEquation


@dataclass(frozen=True, eq=False)
class VelocityProblem:
    """What a resolver solves.

    Attributes:
        levels: One equation per level, the most important first.
        bounds: What q̇ must respect.
        dt: How long q̇ lasts, s; 0 where that is not known.
    """

    levels: tuple[TaskEquation, ...]
    bounds: Bounds
    dt: float = 0.0
