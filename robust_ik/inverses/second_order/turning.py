"""The self-motion that turns a lost direction, for singularities without curvature: wrists, shoulders.

There no motion serves the lost command, not to second order either: the tool stands still along the kernel. But the
lost direction turns, and with it the command comes back into what can be done. Arrays only.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.inverses.second_order.weak_motion import Quartic, chosen_side
from robust_ik.inverses.second_order.weak_rows import WeakRows

FLAT = 0.01
"""κ, 1/rad relative to σ₁, below which there is no curvature."""
DEAD = 0.01
"""Commands of weak rows below this, rad/s, do not make the arm turn."""
UNSERVED, SERVED = 0.8, 0.5
"""Shares of the command left over: above the first the arm turns, below the second it does not."""
LEAST_TURN = 0.005
"""Turning rates up to this, 1/rad, are none: a planar arm told to leave its plane."""
PATIENCE = 0.25
"""Seconds without progress before the arm turns, so that what only passes by is left alone."""
HALF_TURN = 3.2
"""Rad of the fastest joint to one side, before the other side is tried, once. Chosen: what a wrist or shoulder has lost
is found after a quarter turn.
"""


@dataclass(frozen=True, eq=False)
class Turn:
    """What is remembered of a turn.

    Attributes:
        waited: Seconds without progress.
        turned: Rad that the turn has led, to either side.
        way: The joint motion of the turn, (n,); None if there is none.
    """

    waited: float = 0.0
    turned: float = 0.0
    way: Array | None = None

    @property
    def gain(self) -> float:
        """0 to 1: grows after some patience; 0 once both sides have been tried."""
        if self.turned > 3 * HALF_TURN:  # there, back, and as far to the other side
            return 0.0
        return float(np.clip(self.waited / PATIENCE - 1, 0, 1))

    @property
    def back(self) -> bool:
        """Whether it is the other side's turn."""
        return self.turned > HALF_TURN

    def after(self, rows: WeakRows, f: Quartic, z: Array, dt: float) -> Turn:
        """The turn after a step with kernel motion z: begun only without curvature, ended by progress."""
        if rows.speed <= DEAD:
            return Turn()
        idle = (self.way is not None or f.curvature < FLAT) and unserved(rows, f, z) > SERVED
        waited = min(self.waited + dt, 2 * PATIENCE) if idle else max(0.0, self.waited - dt)
        return replace(self, waited=waited) if waited > 0 else Turn()

    def added(self, rows: WeakRows, f: Quartic, z: Array, speed: float, dt: float) -> tuple[Array, Turn]:
        """The kernel motion, (p,), with the turn, and what to remember; z itself where nothing is to be turned."""
        share = self.gain * float(np.clip((unserved(rows, f, z) - SERVED) / (UNSERVED - SERVED), 0, 1))
        share *= min(1.0, max(0.0, rows.speed / DEAD - 1)) * rows.fade
        if share <= 0 or rows.turning.shape[0] == 0:
            return z, self
        _, rates, directions = np.linalg.svd(rows.turning)
        share *= float(np.clip(rates[0] / LEAST_TURN - 1, 0, 1))
        if share <= 0:
            return z, self
        d = directions[0]
        motion = rows.kernel @ d
        if self.way is None:
            first = float(rows.command @ (rows.cross @ d)) / rows.speed
            motion = motion * chosen_side(0.0, first * speed, motion, speed)
        elif self.way @ motion < 0:
            motion = -motion
        way = -motion if self.back else motion
        size = share * speed / float(np.abs(way).max())
        kept = replace(self, way=motion, turned=self.turned + share * speed * dt)
        missing = max(0.0, size - max(0.0, float(way @ (rows.kernel @ z))))
        return z + missing * (rows.kernel.T @ way), kept


def unserved(rows: WeakRows, f: Quartic, z: Array) -> float:
    """The share of the weak command that a kernel motion leaves over."""
    return float(np.linalg.norm(f.residual(z))) / max(float(np.linalg.norm(rows.command)), 1e-300)
