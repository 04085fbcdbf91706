"""Holds joints still as far as other tasks allow."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.compiled_form import CompiledForm, Numbers, joint_form
from robust_ik.control.tasks.posture import joint_equation
from robust_ik.control.tasks.task_arguments import checked_joints, joint_indices
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control import control_layout as slots
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class DampingTask(Task):
    """Joints at rest: q̇ = 0, one row per joint, J of unit rows. In a level with other tasks it damps, by its weight.

    It uses all freedom that is left in these joints: levels below it cannot move them. The Hessian is zero.

    Attributes:
        joints: The joints; default all.
        weight: See `Task`.
    """

    joints: tuple[str, ...] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._store(joints=checked_joints(self.joints))

    structural = ("joints",)
    numbers: ClassVar[dict[str, Numbers]] = {"weight": Numbers(slots.WEIGHT)}

    def form(self, robot: Robot) -> CompiledForm:
        """See `Task.form`."""
        return joint_form(joint_indices(robot, self.joints), slots.AT_REST)

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:  # noqa: ARG002
        """J q̇ = 0, for any q; see `Task.equation`."""
        kept = joint_indices(robot, self.joints)
        zero = np.zeros(len(kept))
        return joint_equation(robot, kept, zero, zero, hessian=hessian, weight=self.weight)
