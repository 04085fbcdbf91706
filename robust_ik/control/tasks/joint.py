"""Brings some joints to given values; the others are free."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_measures, checked_cap, checked_parameter
from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.compiled_form import JOINT_NUMBERS, CompiledForm, Numbers, joint_form
from robust_ik.control.tasks.posture import joint_equation
from robust_ik.control.tasks.task_arguments import checked_joints, joint_indices, one_configuration, one_vector
from robust_ik.errors import InputError
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control import control_layout as slots
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class JointTask(Task):
    """Bring joints to values: ẋ = cap(gain · (target − value)), one row per joint.

    Continuous joints go the short way round. The Hessian is zero.

    Attributes:
        joints: A joint's name, or several.
        target: Their values, (k,) or one number for one joint, rad or m.
        gain: Proportional gain, 1/s.
        max_speed: Cap on the speed of every joint, rad/s or m/s.
        weight: See `Task`.
    """

    joints: str | Sequence[str]
    target: ArrayLike
    gain: float = 1.0
    max_speed: float = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        names = checked_joints(self.joints)
        if names is None:
            raise InputError("joints must be names, got None; PostureTask takes all joints")
        target = one_vector("target", np.atleast_1d(as_measures(self.target, "target", ())), None)
        if target.size != len(names):
            raise InputError(f"target must hold one value for each of {', '.join(names)}, got {target.size}")
        self._store(
            joints=names,
            target=target,
            gain=checked_parameter("gain", self.gain, above=0),
            max_speed=checked_cap("max_speed", self.max_speed),
        )

    structural = ("joints",)
    numbers: ClassVar[dict[str, Numbers]] = JOINT_NUMBERS

    def form(self, robot: Robot) -> CompiledForm:
        """See `Task.form`."""
        return joint_form(joint_indices(robot, tuple(self.joints)), slots.TO_VALUE)

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q; see `Task.equation`."""
        kept = joint_indices(robot, tuple(self.joints))
        values: Array = robot.joint_values(one_configuration(q))
        values[kept] = self.target
        error = robot.difference(q, robot.configuration(values))[kept]
        xdot = np.clip(self.gain * error, -self.max_speed, self.max_speed)
        return joint_equation(robot, kept, xdot, error, hessian=hessian, weight=self.weight)
