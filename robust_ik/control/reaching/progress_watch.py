"""Watches whether a servo makes progress: how fast its error falls, and how noisy the configuration is."""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.svd import length
from robust_ik.robot.robot import Robot

WINDOW, STEPS = 0.25, 10
"""Seconds over which progress is measured, and the least number of steps."""
FORGET = 0.1
"""Seconds after which the noise of measurements is forgotten."""


class Noise:
    """Difference between configurations and their prediction from velocities, rad or m: for a robot at rest, noise."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.size = robot, 0.0
        self._last: Array | None = None

    def add(self, q: Array, previous: Array, dt: float) -> None:
        """Adds the next configuration."""
        if self._last is not None:
            missed = float(np.abs(self.robot.difference(self._last, q) - dt * previous).max())
            share = min(1.0, dt / FORGET)
            self.size += share * (missed - self.size)
        self._last = q.copy()


class Servo:
    """Watch on a servo: its error, in m and rad times a length, and how fast the robot follows it."""

    def __init__(self, robot: Robot, longest_start: float) -> None:
        """Begins a watch.

        Args:
            robot: The robot.
            longest_start: Seconds that joints need to reach their speed.
        """
        self.robot, self.window = robot, WINDOW + longest_start
        self.restart()

    def restart(self) -> None:
        """Forgets all steps seen."""
        self.elapsed, self.gained, self.steps = 0.0, 0.0, 0
        self._last: tuple[Array, Array] | None = None

    def add(self, q: Array, equation: TaskEquation, dt: float) -> None:
        """Adds the next step's equation."""
        units = scaled(equation, self.robot)
        if self._last is not None:
            before, pull = self._last
            self.gained += float(pull @ self.robot.difference(before, q))
            self.elapsed += dt
            self.steps += 1
        self.error, self.asked = length(equation.error * units), length(equation.xdot * units)
        direction = equation.xdot * units / max(self.asked, 1e-300)
        self._last = q.copy(), (direction * units) @ equation.J

    @property
    def due(self) -> bool:
        """Whether the window is over."""
        return self.elapsed >= self.window and self.steps >= STEPS

    @property
    def rate(self) -> float:
        """Speed of the frame in the direction that was asked for, m/s."""
        return self.gained / self.elapsed


def scaled(equation: TaskEquation, robot: Robot) -> Array:
    """Factors that convert the rows of an equation to m, (m,)."""
    lengths = np.zeros(len(equation.xdot), dtype=bool) if equation.lengths is None else equation.lengths
    return np.where(lengths, 1.0, robot.length_scale)
