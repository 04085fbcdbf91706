"""Limiters: they fit one level's motion into the bounds, without changing higher levels.

A limiter gets the motion that the level's inverse wants. It may change only what the level leaves free, or give the
level less; it never uses motions that higher levels need.
"""

from __future__ import annotations

import abc
import math
from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.checks.public_arguments import check_type
from robust_ik.control.within_bounds.bounded_qp import check_backend, share_of
from robust_ik.control.within_bounds.level_fit import Wish, keeping_direction, nearest, slowed, within_speeds
from robust_ik.kernels.control.control_layout import RISING, SOFT

RISE = 2.0
"""How fast the joint speed of a level that was stopped grows again at the most, rad/s² or m/s².

In a step of 20 ms it changes a speed by 0.04 rad/s, within 20 times what a measurement noise of 1e-4 rad makes of a
joint that is held by its own gain of 20/s.
"""


class Limiter(abc.ABC):
    """A way to fit a level's motion into the bounds."""

    @property
    def stops(self) -> bool:
        """Whether one joint at its end may stop the whole level; its share then rises slowly again."""
        return False

    @abc.abstractmethod
    def limit(self, wish: Wish) -> tuple[Array, float]:
        """The motion that the level gets, (n,), and its share of the wish, in [0, 1]."""


@dataclass(frozen=True)
class Sliding(Limiter):
    """The whole motion slower if joints are too fast; if other bounds stop joints, help by other joints, then sliding.

    Speed limits keep the direction and the ratios of joints, as for `Scaling`. At position limits and obstacles other
    joints take over, as for `Saturation`. For the rest of the wish the nearest motion is made, as for
    `QuadraticProgram`: the arm slides along its limits, where limiters that keep the direction stop.
    """

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        scaled, share = slowed(wish)
        if share == 1:
            return scaled, share
        motion = within_speeds(wish)
        if wish.bounds.largest_step(wish.qdot, motion) == 1:
            return motion, share
        kept, share = keeping_direction(replace(wish, motion=motion))
        if share == 1:
            return kept, share_of(wish.reduced.matrix @ wish.motion, wish.reduced.matrix @ kept)
        aside = nearest(replace(wish, qdot=wish.qdot + kept), (1 - share) * motion)[0]
        change = kept + aside
        return change, share_of(wish.reduced.matrix @ wish.motion, wish.reduced.matrix @ change)


@dataclass(frozen=True)
class QuadraticProgram(Limiter):
    """The motion inside the bounds that is nearest to the filtered one, in the metric of `motion_cost`.

    Minimises ½ (q̇' − q̇)ᵀ H (q̇' − q̇) over the level's freedom, where q̇ is the motion of the level's robust inverse,
    slowed as a whole if a joint would be too fast. So any inverse works within limits, and its motion does not change
    if no limit acts. H weighs what the level gets, and gives all motion a cost. The cost avoids shaking, but may take a
    part of the wish although other joints could take over in full, as they do for `Sliding`. Levels one after another
    make it strict (lexicographic).

    Attributes:
        keep_direction: Look instead for the largest share of the motion without turning it, as `Saturation` does.
        backend: A solver that qpsolvers knows; "daqp" comes with this package.

    Source: Escande, Mansard, Wieber 2014 (hierarchical quadratic programming), on the filtered task.
    """

    keep_direction: bool = False
    backend: str = "daqp"

    def __post_init__(self) -> None:
        check_backend(self.backend)
        check_type("keep_direction", self.keep_direction, "bool")

    @property
    def stops(self) -> bool:
        """Whether it keeps the direction."""
        return self.keep_direction

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        scaled, share = slowed(wish)
        if share == 1:
            return scaled, share
        if self.keep_direction:
            return keeping_direction(wish, self.backend)
        return nearest(wish, within_speeds(wish), self.backend)


@dataclass(frozen=True)
class Saturation(Limiter):
    """Saturation in the null space: joints at their bounds stay there, and the level's other joints take over.

    The direction is kept, up to a turn of at most TURN of the wish. If no joints are left to help, or if their help
    would cost more motion than the progress is worth, the level is slowed. It is the optimum of saturating joint after
    joint, with a cost on help: a primal active-set method without a solver's overhead, a few passes with a small QR
    factorisation each.

    Source: Flacco, De Luca, Khatib 2015 (SNS), with rows of any kind as bounds and the level's filtered motion as task.
    """

    @property
    def stops(self) -> bool:
        """Yes."""
        return True

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        scaled, share = slowed(wish)
        return (scaled, share) if share == 1 else keeping_direction(wish)


@dataclass(frozen=True)
class Scaling(Limiter):
    """The whole motion, slowed as much as the tightest bound requires. Keeps the direction; uses no redundancy."""

    @property
    def stops(self) -> bool:
        """Yes."""
        return True

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        return slowed(wish)


class Eased(Limiter):
    """Another limiter's motion, with a share that rises slowly after limits have lowered it.

    A limiter that keeps the direction lets a joint at its end stop all others as soon as it is asked to go on by any
    small amount. Measurement noise then does so every few steps, and the arm would start and stop for ever. So may its
    own motion: what it goes on in one step may bring the joint to its end again. Therefore it starts softly.

    Attributes:
        limiter: The other one.
        dt: Length of the first step, s.
        speed: The largest joint speed that it gave last, if limits have slowed it then; else infinite.
        rise: How much that may grow in a step at the most.
    """

    def __init__(self, limiter: Limiter, dt: float) -> None:
        self.limiter = limiter
        self.dt = dt
        self.speed = math.inf
        self.rise = RISE * dt

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        change, share = self.limiter.limit(wish)
        largest = float(np.abs(wish.motion).max(initial=0.0))
        most = self.speed + min(self.rise, (wish.dt or self.dt) * (self.speed / RISING + SOFT))
        if share * largest > most:
            slower = most / (share * largest)
            change, share = change * slower, share * slower
        self.speed = math.inf if share == 1 else share * largest
        return change, share
