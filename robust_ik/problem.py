"""What passes from tasks to the controller and back: plain frozen values, arrays only."""

from __future__ import annotations

from dataclasses import dataclass

from robust_ik.checks import Array


@dataclass(frozen=True, eq=False)
class TaskEquation:
    """J q̇ = ẋ, and the error that ẋ is meant to reduce.

    Attributes:
        J: Task Jacobian, (m, n).
        xdot: Wanted task velocity, (m,).
        error: Target minus current in the units of the task, (m,).
        hessian: ∂J/∂q, (m, n, n), where somebody asked for it.
    """

    J: Array
    xdot: Array
    error: Array
    hessian: Array | None = None


@dataclass(frozen=True, eq=False)
class Resolution:
    """Joint velocities, and what they could not give.

    Attributes:
        qdot: Joint velocities, (n,), rad/s or m/s.
        residual: ẋ − J q̇: the task velocity that was asked for and is not given, (m,).
    """

    qdot: Array
    residual: Array
