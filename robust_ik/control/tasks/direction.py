"""Points an axis of a frame along a direction; the rotation about it is free."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_cap, checked_parameter, readonly
from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.compiled_form import CompiledForm, Numbers, direction_form
from robust_ik.control.tasks.pose_difference import perpendicular, swing
from robust_ik.control.tasks.pose_feedback import capped
from robust_ik.control.tasks.task_arguments import checked_frame, one_configuration, one_vector
from robust_ik.errors import InputError
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class DirectionTask(Task):
    """Point an axis of a frame along a direction of the world: two rows, the rotation about the direction is free.

    The error is the shortest rotation between the two, right up to π, where one of the many axes is chosen. The rows
    are its parts along two fixed axes perpendicular to `direction`, so that the Hessian is exact.

    Attributes:
        axis: In the frame's axes, (3,), of any length.
        direction: The wanted direction, world axes, (3,), of any length.
        gain: Proportional gain, 1/s.
        max_angular: Cap on the error before the gain, rad.
        frame: Link or joint; default the robot's tip.
        weight: See `Task`.
    """

    axis: Array
    direction: Array
    gain: float = 1.0
    max_angular: float = math.inf
    frame: str | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        checked_frame("frame", self.frame)
        self._store(
            axis=_unit("axis", self.axis),
            direction=_unit("direction", self.direction),
            gain=checked_parameter("gain", self.gain, above=0),
            max_angular=checked_cap("max_angular", self.max_angular),
        )

    structural = ("frame",)
    numbers: ClassVar[dict[str, Numbers]] = {
        "weight": Numbers(slots.WEIGHT),
        "gain": Numbers(slots.GAIN_OF),
        "max_angular": Numbers(slots.ANGULAR),
        "axis": Numbers(slots.AXIS, (3,)),
        "direction": Numbers(slots.TOWARDS, (3,)),
    }

    def form(self, robot: Robot) -> CompiledForm:  # noqa: ARG002
        """See `Task.form`."""
        return direction_form(self.frame)

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q; see `Task.equation`."""
        one_configuration(q)
        across = perpendicular(self.direction)
        error = across @ swing(robot.pose(q, self.frame)[:3, :3] @ self.axis, self.direction)
        J = across @ robot.jacobian(q, self.frame, rows=ROWS[3:])
        H = np.tensordot(across, robot.hessian(q, self.frame, rows=ROWS[3:]), 1) if hessian else None
        return TaskEquation(J, self.gain * capped(error, self.max_angular), error, H, self.weight)


def _unit(name: str, value: ArrayLike) -> Array:
    vector = one_vector(name, value, 3)
    largest = np.abs(vector).max()
    if largest == 0:
        raise InputError(f"{name} must not be zero")
    vector = vector / largest
    return readonly(vector / np.linalg.norm(vector))
