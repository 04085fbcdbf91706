"""Moves a frame with a given velocity, without a target."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array
from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.compiled_form import CompiledForm, Numbers, twist_form
from robust_ik.control.tasks.task_arguments import (
    checked_choice,
    checked_frame,
    checked_selection,
    indices,
    lengths,
    one_configuration,
    one_vector,
    task_rows,
)
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control import control_layout as slots
from robust_ik.robot.robot import Robot

REFERENCES = ("local_world_aligned", "local")


@dataclass(frozen=True, eq=False)
class TwistTask(Task):
    """Move a frame with a twist: ẋ = twist, error zero. Deviations from a path are not corrected.

    Attributes:
        twist: (6,), linear in m/s, then angular in rad/s.
        frame: Link or joint; default the robot's tip.
        reference: "local_world_aligned" (the frame's point, world axes) or "local" (the frame's point and axes).
        rows: Controlled rows, of x y z wx wy wz, along the reference's axes; default the robot's task rows for its
            tip, all six for another frame.
        weight: See `Task`.
    """

    twist: Array
    frame: str | None = None
    reference: Literal["local_world_aligned", "local"] = "local_world_aligned"
    rows: tuple[str, ...] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        checked_frame("frame", self.frame)
        checked_choice("reference", self.reference, REFERENCES)
        self._store(twist=one_vector("twist", self.twist, 6), rows=checked_selection(self.rows))

    structural = ("frame", "rows", "reference")
    numbers: ClassVar[dict[str, Numbers]] = {"weight": Numbers(slots.WEIGHT), "twist": Numbers(slots.FORWARD, (6,))}

    def form(self, robot: Robot) -> CompiledForm:
        """See `Task.form`."""
        in_world = self.reference == "local_world_aligned"
        rows = task_rows(robot, self.frame, self.rows, world_axes=in_world)
        return twist_form(rows, self.frame, along_frame=not in_world)

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q; see `Task.equation`."""
        rows = task_rows(robot, self.frame, self.rows, world_axes=self.reference == "local_world_aligned")
        one_configuration(q)
        J = robot.jacobian(q, self.frame, self.reference, rows=rows)
        H = robot.hessian(q, self.frame, self.reference, rows=rows) if hessian else None
        return TaskEquation(J, self.twist[indices(rows)], np.zeros(len(rows)), H, self.weight, lengths(rows))
