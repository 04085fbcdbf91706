"""Slower at speed limits, aside at all others: the default way to meet limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.resolvers.limiters import Limiter, Scaling, Wish
from robust_ik.resolvers.quadratic_program import nearest


@dataclass(frozen=True)
class Sliding(Limiter):
    """Where joints are too fast, the whole motion slower; then the nearest one inside all bounds.

    Speed limits keep the direction and the joints' ratios, as for `Scaling`. Position limits and distances to obstacles
    turn the motion as little as they can, in the metric of `motion_cost`: the arm slides along them, where limiters
    that keep the direction stop.
    """

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        scaled, scale = Scaling().limit(wish)
        if scale == 1:
            return scaled, scale
        slowed = self._within_speeds(wish)
        if wish.bounds.largest_step(wish.qdot, slowed) == 1:
            return slowed, scale
        return nearest(wish, slowed)

    def _within_speeds(self, wish: Wish) -> Array:
        """The motion, slower where a joint would be faster than it may be."""
        fastest = wish.bounds.fastest
        if fastest is None:
            return wish.motion
        left = np.maximum(fastest - np.sign(wish.motion) * wish.qdot, 0.0)
        too_fast = np.abs(wish.motion) > left
        share = np.min(left[too_fast] / np.abs(wish.motion[too_fast]), initial=1.0)
        return np.asarray(share * wish.motion)
