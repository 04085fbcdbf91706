"""Brings joints to a configuration, usually as a lower level that uses redundancy."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.checks import Array, as_measures, checked_cap, checked_parameter
from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.compiled_form import JOINT_NUMBERS, CompiledForm, Numbers, joint_form
from robust_ik.control.tasks.task_arguments import checked_joints, joint_indices, one_configuration, one_vector
from robust_ik.errors import InputError
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control import control_layout as slots
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class PostureTask(Task):
    """Bring the joints to a configuration: ẋ = cap(gain · (target − q)), one row per joint, J of unit rows.

    Continuous joints go the short way round. The Hessian is zero.

    Attributes:
        target: Configuration, (nq,), such as `robot.rest`.
        gain: Proportional gain, 1/s.
        max_speed: Cap on the speed of every joint, rad/s or m/s.
        joints: The joints; default all.
        weight: See `Task`.

    Source: J-PARSE, eq. (54) and section VIII-B.
    """

    target: Array
    gain: float = 1.0
    max_speed: float = math.inf
    joints: tuple[str, ...] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._store(
            target=one_vector("target", self.target, None),
            gain=checked_parameter("gain", self.gain, above=0),
            max_speed=checked_cap("max_speed", self.max_speed),
            joints=checked_joints(self.joints),
        )

    structural = ("joints",)
    numbers: ClassVar[dict[str, Numbers]] = JOINT_NUMBERS

    def form(self, robot: Robot) -> CompiledForm:
        """See `Task.form`."""
        return joint_form(joint_indices(robot, self.joints), slots.TO_VALUE)

    def number(self, robot: Robot, name: str) -> Any:
        """See `Task.number`: the target as values of the joints."""
        if name != "target":
            return getattr(self, name)
        self._check(robot)
        if self.joints is None and robot.nq == robot.n:
            return self.target
        return robot.joint_values(self.target)[joint_indices(robot, self.joints)]

    def with_numbers(self, robot: Robot, given: dict[str, Any]) -> PostureTask:
        """See `Task.with_numbers`."""
        values = robot.joint_values(self.target)
        values[joint_indices(robot, self.joints)] = as_measures(given["target"], "target", (None,))
        return replace(self, **{**given, "target": robot.configuration(values)})

    def _check(self, robot: Robot) -> None:
        if self.target.size != robot.nq:
            raise InputError(
                f"target must be one configuration of {robot.name}, ({robot.nq},), got shape {self.target.shape}; "
                f"Robot.configuration makes one from joint values, JointTask takes some joints only"
            )

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q; see `Task.equation`."""
        self._check(robot)
        kept = joint_indices(robot, self.joints)
        one_configuration(q)
        error = robot.difference(q, self.target)[kept]
        xdot = np.clip(self.gain * error, -self.max_speed, self.max_speed)
        return joint_equation(robot, kept, xdot, error, hessian=hessian, weight=self.weight)


def joint_equation(
    robot: Robot, kept: NDArray[np.intp], xdot: Array, error: Array, *, hessian: bool, weight: float
) -> TaskEquation:
    """The rows q̇_i = ẋ_i of some joints."""
    H = np.zeros((len(kept), robot.n, robot.n)) if hessian else None
    return TaskEquation(np.eye(robot.n)[kept], xdot, error, H, weight, robot.sliding[kept])
