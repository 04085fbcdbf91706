"""How one level's motion is fitted into the bounds, without touching higher levels.

A limiter gets the motion that the level's inverse wants. It may change only what the level leaves free, or give the
level less; it never uses what higher levels need.
"""

from __future__ import annotations

import abc
from dataclasses import dataclass

from robust_ik.bounds import Bounds
from robust_ik.checks import Array
from robust_ik.resolvers.freedom import Freedom, Reduced
from robust_ik.resolvers.motion_cost import MotionCost, motion_cost


@dataclass(frozen=True, eq=False)
class Wish:
    """One level's wish and where it stands.

    Attributes:
        qdot: What higher levels have settled, inside the bounds, (n,).
        motion: What the level's inverse wants on top, (n,), within `freedom`.
        reduced: The level's Jacobian in `freedom`.
        freedom: What higher levels leave.
        bounds: What must be respected.
        reach: Δt ‖ẋ‖: how far the level wants to go in this step; 0 where that is not known.
    """

    qdot: Array
    motion: Array
    reduced: Reduced
    freedom: Freedom
    bounds: Bounds
    reach: float = 0.0

    @property
    def cost(self) -> MotionCost:
        """What motions of the level cost."""
        return motion_cost(self.reduced, self.reach)


class Limiter(abc.ABC):
    """A way to fit a level's motion into the bounds."""

    @property
    def stops(self) -> bool:
        """Whether one joint at its end may stop a level as a whole; its share then rises slowly in a run."""
        return False

    @abc.abstractmethod
    def limit(self, wish: Wish) -> tuple[Array, float]:
        """The motion that the level gets, (n,), and the share of its wish that this is, in [0, 1]."""


@dataclass(frozen=True)
class Scaling(Limiter):
    """The whole motion slower, as much as the tightest bound asks. Keeps the direction; uses no redundancy."""

    @property
    def stops(self) -> bool:
        """Yes."""
        return True

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        scale = wish.bounds.largest_step(wish.qdot, wish.motion)
        return scale * wish.motion, scale
