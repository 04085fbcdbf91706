"""Hold joints still as far as other tasks let them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.posture import joint_equation
from robust_ik.control.tasks.task_arguments import checked_joints, joint_indices
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class DampingTask(Task):
    """Joints at rest: q̇ = 0, one row per joint, J of unit rows. In a level with others it damps, by its weight.

    It takes what is left: levels below it get nothing of these joints. The Hessian is zero.

    Attributes:
        joints: The joints it is about; default all.
        weight: See `Task`.
    """

    joints: tuple[str, ...] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._store(joints=checked_joints(self.joints))

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:  # noqa: ARG002
        """J q̇ = 0, whatever q; see `Task.equation`."""
        kept = joint_indices(robot, self.joints)
        zero = np.zeros(len(kept))
        return joint_equation(robot, kept, zero, zero, hessian=hessian, weight=self.weight)
