"""The recursion of task priority, with any robust inverse."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from robust_ik.checks import Array
from robust_ik.control.resolvers.priority_resolver import PriorityResolver, Settled
from robust_ik.control.within_bounds.filtered_motion import filtered_motion


@dataclass(frozen=True)
class TaskPriority(PriorityResolver):
    """q̇ᵢ = q̇ᵢ₋₁ + (Jᵢ Nᵢ₋₁)# (ẋᵢ − Jᵢ q̇ᵢ₋₁), each level in the null space Nᵢ₋₁ of those before.

    The projectors are exact and undamped, whatever inverse # is: a lower level never moves a higher one. Motions of the
    levels before are taken into account. At an algorithmic singularity, where levels want the same joints, # bounds the
    speeds of the lower level.

    Source: Kim, Marani, Chung, Yuh, eq. (15), after Nakamura 1991 and Siciliano-Slotine 1991.
    """

    source: ClassVar[str] = "Nakamura 1991; Siciliano-Slotine 1991; Kim-Marani-Chung-Yuh, eq. (15)"

    def motion(self, settled: Settled) -> Array:
        """(J N)# (ẋ − J q̇); see `PriorityResolver.motion`."""
        return filtered_motion(settled.inverse, settled.reduced[-1], settled.equation, settled.missing, settled.freedom)
