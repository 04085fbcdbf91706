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
from robust_ik.kernels.second_order.second_order_layout import (
    AGAINST,
    BRISK,
    DEAD,
    EASE,
    FLAT,
    HALF_TURN,
    LEAST_TURN,
    OTHER,
    PATIENCE,
    SERVED,
    SETTLED,
    SLOWEST,
    TINY,
    UNSERVED,
)


@dataclass(frozen=True, eq=False)
class Turn:
    """What is remembered of a turn.

    Attributes:
        waited: Seconds without progress.
        progressed: Seconds with it.
        turned: Rad that the turn has led, to either side.
        way: The joint motion of the turn, (n,); None before it begins.
        asked: The direction of ẋ that it is for, (m,); None before the first.
    """

    waited: float = 0.0
    progressed: float = 0.0
    turned: float = 0.0
    way: Array | None = None
    asked: Array | None = None

    @property
    def gain(self) -> float:
        """From 1 over 0 to −1 and 0: grows after some patience, changes sides once, ends."""
        patience = float(np.clip(self.waited / PATIENCE - 1, 0, 1))
        side = float(np.clip((HALF_TURN - self.turned) / EASE, -1, 1))
        return patience * side * float(np.clip((3 * HALF_TURN - self.turned) / EASE, 0, 1))

    def after(self, xdot: Array, share: float, curvature: float, dt: float) -> Turn:
        """The turn after a step: begun only without curvature, given up by progress or another command.

        Args:
            xdot: ẋ, (m,).
            share: Of the weak command, what the step leaves over; 0 where nothing is weak.
            curvature: κ.
            dt: s.
        """
        size = float(np.linalg.norm(xdot))
        asked = xdot / size if size > 0 else self.asked
        turn = self if self.asked is None or asked is None or asked @ self.asked > OTHER else Turn()
        turn = replace(turn, asked=asked if turn.asked is None else turn.asked)
        if share > SERVED and (turn.way is not None or curvature < FLAT):
            return replace(turn, waited=min(turn.waited + dt, 2 * PATIENCE), progressed=0.0)
        turn = replace(turn, waited=max(0.0, turn.waited - dt), progressed=turn.progressed + (share <= SERVED) * dt)
        return Turn() if turn.progressed > SETTLED else turn

    def added(self, rows: WeakRows, f: Quartic, z: Array, speed: float, dt: float) -> tuple[Array, Turn]:
        """The kernel motion, (p,), with the turn, and what to remember; z itself where nothing is to be turned."""
        share = float(np.clip((unserved(rows, f, z) - SERVED) / (UNSERVED - SERVED), 0, 1)) * rows.fade
        share *= float(np.clip((rows.speed - DEAD) / (BRISK - DEAD), 0, 1))
        if share <= 0 or self.waited <= PATIENCE or rows.turning.shape[0] == 0:
            return z, self
        _, rates, directions = np.linalg.svd(rows.turning)
        share *= float(np.clip(rates[0] / LEAST_TURN - 1, 0, 1))
        if share <= 0:
            return z, self
        motion = rows.kernel @ directions[0]
        if self.way is None:
            first = float(rows.command @ (rows.cross @ directions[0])) / rows.speed
            motion = motion * chosen_side(0.0, first * speed, motion, speed)
        elif self.way @ motion < 0:
            motion = -motion
        counted = max(abs(self.gain), SLOWEST) * share * speed * dt
        kept = replace(self, way=motion, turned=self.turned + counted)
        way = float(np.sign(self.gain)) * (rows.kernel.T @ motion)
        size = share * abs(self.gain) * speed / float(np.abs(motion).max())
        wrong = -float(rows.command @ (f.D @ way)) / max(float(np.linalg.norm(rows.command)), TINY)
        if wrong > 0:
            size = min(size, AGAINST * rows.speed / wrong)
        return z + max(0.0, size - max(0.0, float(way @ z))) * way, kept


def unserved(rows: WeakRows, f: Quartic, z: Array) -> float:
    """The share of the weak command that a kernel motion leaves over."""
    served = f.c - f.residual(z)
    return float(np.linalg.norm(rows.command - served)) / max(float(np.linalg.norm(rows.command)), TINY)
