"""Follows a path point by point: iterates to each point in turn, without time. No simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from robust_ik.analysis.newton_iteration import NewtonResult, newton
from robust_ik.checks import Array
from robust_ik.control.tasks import Follow, Task
from robust_ik.errors import InputError
from robust_ik.inverses import RobustInverse
from robust_ik.robot.robot import Robot
from robust_ik.simulation.scenario import Scenario

Function = Callable[[Array], Array]


def reach_points(
    scenario: Scenario,
    method: RobustInverse | str,
    times: Sequence[float],
    *,
    step: float = 1.0,
    tolerance: float = 1e-9,
    max_iterations: int = 2000,
) -> tuple[NewtonResult, ...]:
    """Newton's iteration to several points of a scenario's path, each from the end of the one before.

    Gain, caps, feed-forward, limits, lower levels and time step of the scenario are ignored. A simulation of the
    scenario does the same with *one* iteration for each time step, ξ = gain · dt.

    Args:
        scenario: The scenario; its motion must be a `Follow`, as in scenarios read from files.
        method: An inverse, or the label of one in the scenario.
        times: Times of the points on the path, s.
        step: ξ in (0, 1].
        tolerance: δ > 0, in the units of the task.
        max_iterations: Cap for each point.

    Returns:
        A result for each point.

    Raises:
        InputError: The scenario follows no path, the method is no inverse, or another argument is not valid.

    Source: Duleba 2023, eq. (3) and section 5.
    """
    inverse = scenario.method(method) if isinstance(method, str) else method
    if not isinstance(inverse, RobustInverse):
        raise InputError(f"points are iterated for with an inverse, got {inverse!r}")
    if not isinstance(scenario.motion, Follow):
        raise InputError(f"{scenario.name} follows no path: its motion is {type(scenario.motion).__name__}")
    q, results = scenario.q0, []
    for time in times:
        kinematics, jacobian, hessian = _functions(scenario.motion(time)[0][0], scenario.robot)
        found = newton(
            kinematics, jacobian, inverse, q, 0 * kinematics(q), step=step, tolerance=tolerance,
            max_iterations=max_iterations, hessian=hessian if inverse.needs_hessian else None,
            integrate=scenario.robot.integrate,
        )  # fmt: skip
        q = found.q
        results.append(found)
    return tuple(results)


def _functions(task: Task, robot: Robot) -> tuple[Function, Function, Function]:
    """Minus the task's error, and its first and second derivatives, as functions of q."""

    def error(q: Array) -> Array:
        return -task.equation(robot, q).error

    def jacobian(q: Array) -> Array:
        return task.equation(robot, q).J

    def hessian(q: Array) -> Array:
        return np.asarray(task.equation(robot, q, hessian=True).hessian)

    return error, jacobian, hessian
