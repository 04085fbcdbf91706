"""Task priority without algorithmic singularities, at the cost of the lower levels' accuracy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from robust_ik.checks import Array
from robust_ik.control.resolvers.priority_resolver import PriorityResolver, Settled
from robust_ik.control.within_bounds.filtered_motion import filtered_motion
from robust_ik.control.within_bounds.null_space import Freedom


@dataclass(frozen=True)
class DecoupledPriority(PriorityResolver):
    """q̇ᵢ = q̇ᵢ₋₁ + Nᵢ₋₁ Jᵢ# ẋᵢ: each level inverts its own Jacobian; the result is then projected.

    Nᵢ₋₁ projects onto the null space of the levels before. The first level compensates motions that limits force on it,
    as in `TaskPriority`.

    No algorithmic singularity can make it fast: ‖Nᵢ₋₁ Jᵢ# ẋᵢ‖ ≤ ‖Jᵢ# ẋᵢ‖. But a level's task is met only if
    Jᵢ Nᵢ₋₁ Jᵢ# = I on ẋᵢ and the levels before do not move it, for example if the rows of J are orthogonal.

    Source: Chiaverini 1997, singularity-robust task-priority redundancy resolution.
    """

    source: ClassVar[str] = "Chiaverini 1997"

    def motion(self, settled: Settled) -> Array:
        """J# ẋ; see `PriorityResolver.motion`, which drops the part outside the freedom."""
        equation = settled.equation
        own = Freedom.whole(len(settled.qdot))
        wanted = settled.missing if settled.index == 0 else equation.xdot  # limits may have moved joints already
        return filtered_motion(settled.inverse, own.reduce(equation.J), equation, wanted, own)
