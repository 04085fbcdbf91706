"""Climbs a measure of dexterity, away from singularities: one row along its gradient."""

from __future__ import annotations

import abc
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_parameter
from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.compiled_form import Numbers
from robust_ik.control.tasks.task_arguments import checked_frame, checked_selection, one_configuration, task_rows
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control import control_layout as slots
from robust_ik.robot.robot import Robot

FADE = 0.1
"""Fraction of the threshold, just below it, over which the weight of the row falls to zero."""

FLAT = 1e-12
"""A gradient shorter than this fraction of the largest entry of ∂J/∂q is rounding error."""

NUDGE = 1e-3
"""Distance from a singularity with zero gradient at which a way out is looked for, rad (or m)."""


@dataclass(frozen=True, eq=False)
class ClimbingTask(Task):
    """Climb a measure w(J) ≥ 0: one row, the unit vector g/‖g‖ of its gradient g = ∂w/∂q.

    The joint speed asked for is the least of
      * gain · (threshold − w)/‖g‖, so that ẇ = gain · (threshold − w), if there is a threshold;
      * gain · ‖g‖/w, the steepest climb of ln w, which ends smoothly where w has a maximum;
      * max_speed.

    With unit length the row has the same weight on every robot. At and above the threshold the row is zero: it asks for
    nothing and leaves lower levels free. Just below, its weight fades, so that within a level nothing jumps. Levels
    *below* it gain or lose one direction of motion at the threshold: make it the last level, let it share a level, or
    use a limit if w must only not fall.

    At a singularity w has a kink, with two opposite ways out, and either is right. Where singularities cross, like
    those of a UR5's elbow and wrist at zero, g vanishes too; then g at a point beside it leads out. If g vanishes at a
    maximum, the row is zero.

    There is no Hessian: it would need third derivatives of the kinematics.

    Attributes:
        gain: 1/s, and rad² (or m²) per second for the climb of ln w.
        threshold: The w above which nothing is asked, in the units of w; default none: climb always.
        max_speed: Cap on the length of the joint velocity that it asks for, rad/s (and m/s).
        frame: Link or joint; default the robot's tip.
        rows: The rows of the measure, of x y z wx wy wz; default the robot's task rows for its tip, all six for another
            frame.
        weight: See `Task`.
    """

    gain: float = 1.0
    threshold: float | None = None
    max_speed: float = 0.5
    frame: str | None = None
    rows: tuple[str, ...] | None = field(default=None, kw_only=True)

    numbers: ClassVar[dict[str, Numbers]] = {
        "weight": Numbers(slots.WEIGHT),
        "gain": Numbers(slots.GAIN_OF),
        "max_speed": Numbers(slots.TOP_SPEED),
        "threshold": Numbers(slots.THRESHOLD),
    }

    def __post_init__(self) -> None:
        super().__post_init__()
        checked_frame("frame", self.frame)
        if self.threshold is not None:
            self._store(threshold=checked_parameter("threshold", self.threshold, above=0))
        self._store(
            gain=checked_parameter("gain", self.gain, above=0),
            max_speed=checked_parameter("max_speed", self.max_speed, above=0),
            rows=checked_selection(self.rows),
        )

    def number(self, robot: Robot, name: str) -> Any:  # noqa: ARG002
        """See `Task.number`."""
        value = getattr(self, name)
        return np.inf if value is None else value

    def with_numbers(self, robot: Robot, given: dict[str, Any]) -> Task:
        """See `Task.with_numbers`."""
        threshold = given["threshold"]
        return super().with_numbers(robot, {**given, "threshold": None if threshold == np.inf else threshold})

    @abc.abstractmethod
    def measure(self, J: Array, hessian: Array, rows: tuple[str, ...]) -> tuple[float, Array]:
        """The measure and its gradient.

        Args:
            J: (m, n).
            hessian: ∂J/∂q, (m, n, n).
            rows: Names of the rows of J, m.

        Returns:
            w ≥ 0 and ∂w/∂q, (n,).
        """

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:  # noqa: ARG002
        """J q̇ = ẋ at q, without a Hessian; see `Task.equation`."""
        rows = task_rows(robot, self.frame, self.rows)
        value, gradient = self._way(robot, one_configuration(q), rows)
        slope = float(np.linalg.norm(gradient))
        missing = np.inf if self.threshold is None else self.threshold - value
        if missing <= 0 or slope == 0:
            return TaskEquation(np.zeros((1, robot.n)), np.zeros(1), np.zeros(1), None, self.weight)
        steepest = slope / value if value > 0 else np.inf
        error = np.array([min(missing / slope, steepest, self.max_speed / self.gain)])
        fade = 1.0 if self.threshold is None else min(1.0, missing / (FADE * self.threshold))
        return TaskEquation(gradient[None] / slope, self.gain * error, error, None, self.weight * fade)

    def _way(self, robot: Robot, q: ArrayLike, rows: tuple[str, ...]) -> tuple[float, Array]:
        """The measure at q, and the gradient that leads up from there; zero at a maximum."""
        value, gradient, flat = self._measured(robot, q, rows)
        if not flat:
            return value, gradient
        generic = np.cos(np.arange(1, robot.n + 1))
        beside, gradient, _ = self._measured(robot, robot.integrate(q, NUDGE * generic), rows)
        return value, gradient if beside > 1e6 * value else np.zeros(robot.n)

    def _measured(self, robot: Robot, q: ArrayLike, rows: tuple[str, ...]) -> tuple[float, Array, bool]:
        """The measure, its gradient, and whether the gradient is only rounding error."""
        J, H = robot.jacobian(q, self.frame, rows=rows), robot.hessian(q, self.frame, rows=rows)
        value, gradient = self.measure(J, H, rows)
        return value, gradient, bool(np.abs(gradient).max() <= FLAT * np.abs(H).max())
