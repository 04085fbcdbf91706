"""Keeps joints out of the outer parts of their ranges, as a lower level: a redundant arm then meets limits later."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.checks import Array, checked_cap, checked_parameter
from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.compiled_form import CompiledForm, Numbers, entries_of, joint_form
from robust_ik.control.tasks.posture import joint_equation
from robust_ik.control.tasks.task_arguments import checked_joints, joint_indices, one_configuration
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control import control_layout as slots
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class JointRangeTask(Task):
    """Bring joints that are near an end of their range back: ẋ = cap(gain · (nearest value of the inner range − q)).

    One row per joint, J of unit rows. The inner range lies between lower + margin · range and upper − margin · range.
    A joint inside it asks for nothing, nor does a joint without two finite limits. As a level below a tool's task it
    uses the freedom left: a redundant arm then meets its limits later, and reaches more (`docs/closed_loop.md`); an arm
    that is not redundant has no such freedom. The Hessian is zero.

    Attributes:
        margin: The outer fraction of a joint's range on either side, in (0, 0.5).
        gain: Proportional gain, 1/s.
        max_speed: Cap on the speed of every joint, rad/s or m/s.
        joints: The joints; default all.
        weight: See `Task`.

    Source: Liégeois 1977, the gradient of a distance from joint limits projected into the null space; here it is zero
    in the inner range.
    """

    margin: float = 0.3
    gain: float = 1.0
    max_speed: float = math.inf
    joints: tuple[str, ...] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._store(
            margin=checked_parameter("margin", self.margin, above=0, below=0.5),
            gain=checked_parameter("gain", self.gain, above=0),
            max_speed=checked_cap("max_speed", self.max_speed),
            joints=checked_joints(self.joints),
        )

    structural = ("joints", "margin")
    numbers: ClassVar[dict[str, Numbers]] = {
        "weight": Numbers(slots.WEIGHT),
        "gain": Numbers(slots.GAIN_OF),
        "max_speed": Numbers(slots.FASTEST),
    }

    def form(self, robot: Robot) -> CompiledForm:
        """See `Task.form`."""
        kept = joint_indices(robot, self.joints)
        made = joint_form(kept, slots.TO_RANGE)
        entries_of(made.record)[:, slots.FROM], entries_of(made.record)[:, slots.TO] = self._inner(robot, kept)
        return made

    def _inner(self, robot: Robot, kept: NDArray[np.intp]) -> tuple[Array, Array]:
        """The ends of the inner ranges of some joints, infinite without two finite limits."""
        lower, upper = robot.lower[kept], robot.upper[kept]
        ends = np.isfinite(lower) & np.isfinite(upper)
        edge = self.margin * np.where(ends, upper - lower, 0.0)
        return np.where(ends, lower + edge, -np.inf), np.where(ends, upper - edge, np.inf)

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q; see `Task.equation`."""
        kept = joint_indices(robot, self.joints)
        values = robot.joint_values(one_configuration(q))[kept]
        error = np.clip(values, *self._inner(robot, kept)) - values
        xdot = np.clip(self.gain * error, -self.max_speed, self.max_speed)
        return joint_equation(robot, kept, xdot, error, hessian=hessian, weight=self.weight)
