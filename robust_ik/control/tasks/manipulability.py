"""Climbs the manipulability."""

from __future__ import annotations

from dataclasses import dataclass

from robust_ik.checks import Array
from robust_ik.control.tasks.measure_climbing import ClimbingTask
from robust_ik.kinematics.singular_value_gradients import manipulability_gradient
from robust_ik.kinematics.svd import manipulability


@dataclass(frozen=True, eq=False)
class ManipulabilityTask(ClimbingTask):
    """Climb the manipulability w = Πσ; arguments and behaviour as for `ClimbingTask`.

    Source: Yoshikawa 1985; gradient: Kim, Marani, Chung, Yuh, eq. (30), in the form without J⁺.
    """

    def measure(self, J: Array, hessian: Array, rows: tuple[str, ...]) -> tuple[float, Array]:  # noqa: ARG002
        """Πσ and its gradient; see `ClimbingTask.measure`."""
        return float(manipulability(J)), manipulability_gradient(J, hessian)
