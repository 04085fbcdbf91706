"""Climbs the manipulability."""

from __future__ import annotations

from dataclasses import dataclass

from robust_ik.checks import Array
from robust_ik.control.tasks.compiled_form import CompiledForm, climbing_form
from robust_ik.control.tasks.measure_climbing import ClimbingTask
from robust_ik.control.tasks.task_arguments import task_rows
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kinematics.singular_value_gradients import manipulability_gradient
from robust_ik.kinematics.svd import manipulability
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class ManipulabilityTask(ClimbingTask):
    """Climb the manipulability w = Πσ; arguments and behaviour as for `ClimbingTask`.

    Source: Yoshikawa 1985; gradient: Kim, Marani, Chung, Yuh, eq. (30), in the form without J⁺.
    """

    structural = ("frame", "rows")

    def form(self, robot: Robot) -> CompiledForm:
        """See `Task.form`."""
        rows = task_rows(robot, self.frame, self.rows)
        return climbing_form(rows, self.frame, slots.OF_PRODUCT, -1, 1.0, robot.n)

    def measure(self, J: Array, hessian: Array, rows: tuple[str, ...]) -> tuple[float, Array]:  # noqa: ARG002
        """Πσ and its gradient; see `ClimbingTask.measure`."""
        return float(manipulability(J)), manipulability_gradient(J, hessian)
