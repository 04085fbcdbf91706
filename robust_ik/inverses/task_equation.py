"""The equation of one task, J q̇ = ẋ, with its error: the whole input of an inverse."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array


@dataclass(frozen=True, eq=False)
class TaskEquation:
    """J q̇ = ẋ, and the error that ẋ is meant to reduce.

    Attributes:
        J: Task Jacobian, (m, n).
        xdot: Wanted task velocity, (m,).
        error: Target minus current in the units of the task, (m,).
        hessian: ∂J/∂q, (m, n, n), if it was asked for and the task has one; else None.
        weight: Weight of its rows against the rows of other tasks of the same level.
        lengths: Which rows of error are in metres, (m,); None if none is. Robots much larger or smaller than a metre
            have units of their own.
    """

    J: Array
    xdot: Array
    error: Array
    hessian: Array | None = None
    weight: float = 1.0
    lengths: NDArray[np.bool_] | None = None


def stacked(equations: Sequence[TaskEquation]) -> TaskEquation:
    """The equations of one level as one, every row times its task's weight.

    The Hessian is there if every equation has one.
    """
    if len(equations) == 1 and equations[0].weight == 1.0:
        return equations[0]
    hessians = [each.weight * each.hessian for each in equations if each.hessian is not None]
    return TaskEquation(
        J=np.concatenate([each.weight * each.J for each in equations]),
        xdot=np.concatenate([each.weight * each.xdot for each in equations]),
        error=np.concatenate([each.weight * each.error for each in equations]),
        hessian=np.concatenate(hessians) if len(hessians) == len(equations) else None,
        lengths=np.concatenate([_lengths(each) for each in equations]),
    )


def _lengths(equation: TaskEquation) -> NDArray[np.bool_]:
    return np.zeros(len(equation.xdot), dtype=bool) if equation.lengths is None else equation.lengths
