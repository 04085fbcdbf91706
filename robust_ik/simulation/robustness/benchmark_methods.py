"""What the benchmark runs: inverses and controllers, each behind the same function from commands to q̇."""

from __future__ import annotations

import abc
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.length_scale import chosen_length_scale
from robust_ik.control.limits import JointLimits
from robust_ik.control.resolvers import Resolver
from robust_ik.control.tasks import TwistTask
from robust_ik.control.velocity_controller import VelocityController
from robust_ik.inverses import RobustInverse, SecondOrder
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot
from robust_ik.simulation.robustness.benchmark_scenario import RobustnessScenario

Commands = Callable[[Array, Array, Array], Array]
"""From configurations (N, nq), commands (N, m) and errors (N, m) of the first N runs to joint velocities, (N, n)."""
Made = Callable[[RobustnessScenario], RobustInverse]
"""Makes an inverse for the limits of a scenario."""


class BenchmarkMethod(abc.ABC):
    """A method that the benchmark can run."""

    @abc.abstractmethod
    def begin(self, robot: Robot, scenarios: Sequence[RobustnessScenario]) -> Commands:
        """What answers the steps of runs side by side, all with the same dt; the longest runs come first.

        Args:
            robot: The robot.
            scenarios: One for each run.
        """


@dataclass(frozen=True)
class InverseMethod(BenchmarkMethod):
    """An inverse alone, without limits.

    Attributes:
        made: Makes it.
    """

    made: Made

    @classmethod
    def of(cls, inverse: RobustInverse) -> InverseMethod:
        """An inverse that is the same for every robot."""
        return cls(lambda scenario: inverse)  # noqa: ARG005

    def begin(self, robot: Robot, scenarios: Sequence[RobustnessScenario]) -> Commands:
        """See `BenchmarkMethod.begin`; inverses without a memory invert all at once."""
        inverse = self.made(scenarios[0])
        unit = chosen_length_scale(robot, [inverse], None)
        linear = np.array([row in ("x", "y", "z") for row in robot.rows])
        rows, joints = np.where(linear, 1 / unit, 1.0), np.where(robot.sliding, unit, 1.0)
        plain = type(inverse).velocity is RobustInverse.velocity and type(inverse).begin is RobustInverse.begin
        runs = [inverse.begin(each.dt) for each in scenarios]

        def commands(q: Array, xdot: Array, error: Array) -> Array:
            J, wanted = rows[:, None] * robot.jacobian(q) * joints, rows * xdot
            if plain:
                return np.asarray(joints * inverse.solve(J, wanted))
            bent = rows[:, None, None] * robot.hessian(q) * joints[:, None] * joints if inverse.needs_hessian else None
            found = [
                run.velocity(
                    TaskEquation(J[i], wanted[i], rows * error[i], None if bent is None else bent[i], 1.0, linear)
                )
                for i, run in enumerate(runs[: len(q)])
            ]
            return np.asarray(joints * np.array(found))

        return commands


@dataclass(frozen=True)
class ControllerMethod(BenchmarkMethod):
    """A `VelocityController` that is told the speed and acceleration limits; position limits are left out.

    Attributes:
        made: Makes its resolver or inverse for a scenario; None is the controller's default.
    """

    made: Callable[[RobustnessScenario], Resolver | RobustInverse | None]

    def begin(self, robot: Robot, scenarios: Sequence[RobustnessScenario]) -> Commands:
        """See `BenchmarkMethod.begin`."""
        free = np.full(robot.n, np.inf)
        runs = [
            VelocityController(
                robot,
                self.made(each),
                JointLimits.of(robot, lower=-free, upper=free, velocity=each.speed, acceleration=each.acceleration),
            )
            for each in scenarios
        ]
        places = [ROWS.index(row) for row in robot.rows]

        def commands(q: Array, xdot: Array, error: Array) -> Array:  # noqa: ARG001
            twists = np.zeros((len(q), 6))
            twists[:, places] = xdot
            stepped = zip(runs, scenarios, q, twists)
            return np.array([run.step(at, TwistTask(twist), each.dt).qdot for run, each, at, twist in stepped])

        return commands


def documented(kind: type[RobustInverse]) -> InverseMethod:
    """An inverse as its documentation sets it up: made without arguments; `SecondOrder` from the joint limits."""
    if kind is SecondOrder:
        return InverseMethod(lambda each: SecondOrder.from_limits(each.speed, each.acceleration))
    return InverseMethod.of(kind())
