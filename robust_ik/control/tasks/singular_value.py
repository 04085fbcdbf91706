"""Climbs one singular value, by default the smallest."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, checked_parameter
from robust_ik.control.tasks.compiled_form import CompiledForm, climbing_form
from robust_ik.control.tasks.measure_climbing import ClimbingTask
from robust_ik.control.tasks.task_arguments import task_rows
from robust_ik.errors import InputError
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kinematics.singular_value_gradients import singular_value_gradients
from robust_ik.kinematics.svd import RANK_TOLERANCE, svd
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot

CLUSTER = 1e-3
"""Singular values closer to each other than this fraction of the largest are climbed together."""


@dataclass(frozen=True, eq=False)
class SingularValueTask(ClimbingTask):
    """Climb a singular value σ_i of the task Jacobian; arguments and behaviour as for `ClimbingTask`.

    If singular values coincide, the gradient of each is arbitrary. So those within CLUSTER σ₁ of σ_i count too, with
    less weight the further away they are: if they coincide it is the gradient of their mean, which is not arbitrary,
    and nothing jumps where they cross. If several are zero, the steepest gradient is taken, which depends on the
    arbitrary basis: any way out is right.

    Attributes:
        index: Index in descending order; default the last, the smallest.
        length_scale: m per rad, multiplies the angular rows, so that metres and radians can be compared; default the
            robot's.

    Source: Almarkhi-Maciejewski, eq. (7).
    """

    index: int = field(default=-1, kw_only=True)
    length_scale: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.index, bool) or not isinstance(self.index, (int, np.integer)):
            raise InputError(f"index must be a whole number, got {self.index!r}")
        if self.length_scale is not None:
            self._store(length_scale=checked_parameter("length_scale", self.length_scale, above=0))

    structural = ("frame", "rows", "index", "length_scale")

    def form(self, robot: Robot) -> CompiledForm:
        """See `Task.form`."""
        rows, scale = task_rows(robot, self.frame, self.rows), self.length_scale or robot.length_scale
        return climbing_form(rows, self.frame, slots.OF_SIGMA, self.index, scale, robot.n)

    def equation(self, robot: Robot, q: ArrayLike, *, hessian: bool = False) -> TaskEquation:
        """J q̇ = ẋ at q; see `ClimbingTask.equation`."""
        told = self if self.length_scale is not None else replace(self, length_scale=robot.length_scale)
        return super(SingularValueTask, told).equation(robot, q, hessian=hessian)

    def measure(self, J: Array, hessian: Array, rows: tuple[str, ...]) -> tuple[float, Array]:
        """σ_i and its gradient; see `ClimbingTask.measure`."""
        scale = np.array([1.0 if row in ROWS[:3] else self.length_scale or 1.0 for row in rows])
        J, hessian = scale[:, None] * J, scale[:, None, None] * hessian
        s = svd(J).s
        if not -len(s) <= self.index < len(s):
            span = f"[{-len(s)}, {len(s) - 1}] for {len(s)} singular values"
            raise InputError(f"index must lie in {span}, got {self.index}")
        gradients = singular_value_gradients(J, hessian)
        value = float(s[self.index])
        zeros = s <= RANK_TOLERANCE * s[0]
        if zeros[self.index]:
            among = gradients[zeros]
            return value, among[np.argmax(np.linalg.norm(among, axis=1))]
        share = np.where(zeros, 0.0, np.maximum(0.0, 1 - np.abs(s - value) / (CLUSTER * s[0])))
        return value, np.asarray(share @ gradients / share.sum())
