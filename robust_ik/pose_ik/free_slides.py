"""Slides without limits in front of a chain: a search for a target far away is one nearby. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.kinematics.chain import Chain


@dataclass(frozen=True, eq=False)
class FreeSlides:
    """The slides that a chain begins with, in fixed directions of the world: of a mobile base, or of a gantry.

    Where they have no limits, a target that is moved along them has the same solutions, moved as far. So a target far
    away is brought in view of the starts, which are near zero.

    Attributes:
        places: Their entries in q, (k,).
        directions: How they move the frame, m per m, world axes, (k, 3).
        readings: How far each must go for a motion of the target, by its rows, (k, 3).
        unit: The travel is a whole number of these, m, so that near targets are as they were.
    """

    places: NDArray[np.int_]
    directions: Array
    readings: Array
    unit: float

    @classmethod
    def of(cls, chain: Chain, lower: Array, upper: Array, unit: float) -> FreeSlides | None:
        """Those of a chain; None if there are none, or their directions are not independent.

        Args:
            chain: The joints that move the frame.
            lower: Limits of the robot's n joints, (n,).
            upper: The same.
            unit: A length, m.
        """
        turned, places, directions = np.eye(3), [], []
        for i, column in enumerate(chain.column):
            endless = np.isneginf(lower[column]) and np.isposinf(upper[column])
            alone = np.count_nonzero(chain.column == column) == 1 and chain.factor[i] != 0
            if not (chain.sliding[i] and endless and alone):
                break
            turned = turned @ chain.rotations[i]
            places.append(int(chain.place[i]))
            directions.append(chain.factor[i] * turned[:, 2])
        if not places or np.linalg.matrix_rank(directions) < len(places):
            return None
        moved = np.array(directions)
        return cls(np.array(places), moved, np.linalg.pinv(moved).T, unit)

    def travel(self, T: Array) -> Array:
        """How far the slides go towards targets (..., 4, 4), (..., k), m."""
        # Written out, so that one target gives the bits that many give.
        x, y, z = (T[..., row, 3, None] for row in range(3))
        along = x * self.readings[:, 0] + y * self.readings[:, 1] + z * self.readings[:, 2]
        return np.asarray(self.unit * np.round(along / self.unit))

    def near(self, T: Array, travel: Array) -> Array:
        """Targets (..., 4, 4), brought back by the travel of the slides, (..., k)."""
        moved = T.copy()
        for slide, direction in enumerate(self.directions):
            moved[..., :3, 3] -= travel[..., slide, None] * direction
        return moved

    def moved(self, q: Array, travel: Array) -> Array:
        """Configurations (..., nq) with the slides moved, (..., k)."""
        moved = q.copy()
        moved[..., self.places] += travel
        return moved
