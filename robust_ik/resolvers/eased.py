"""A share that falls at once and rises in half a second: for limiters that stop a level as a whole."""

from __future__ import annotations

from robust_ik.checks import Array
from robust_ik.resolvers.limiters import Limiter, Wish

RISE = 0.5
"""How long a share takes from nothing to all, s."""


class Eased(Limiter):
    """Another limiter's motion, slower for a moment after limits have slowed it.

    A limiter that keeps the direction lets a joint at its end stop all others as soon as it is asked to go on, by ever
    so little. Noise of what is measured then asks it every few steps, and the arm would start and stop for ever.

    Attributes:
        limiter: The other one.
        share: What it gave last.
    """

    def __init__(self, limiter: Limiter, dt: float) -> None:
        self.limiter = limiter
        self.share = 1.0
        self._rise = dt / RISE

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        change, share = self.limiter.limit(wish)
        most = self.share + self._rise
        if share > most:
            change, share = change * (most / share), most
        self.share = share
        return change, share
