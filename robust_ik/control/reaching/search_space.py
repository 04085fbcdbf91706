"""The configurations that a plan may use: joints that move a frame, their limits, and other forbidden regions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.limits import JointLimits, Limit
from robust_ik.robot.robot import Robot

UNHURRIED = 1.0
"""Speed on a path, rad/s or m/s, of joints that have no speed limit of any kind."""
LOOK = 0.05
"""Distance to what is forbidden, m, beyond which nothing is checked."""


@dataclass(frozen=True, eq=False)
class Space:
    """The joint values of a robot, (n,), that limits allow.

    Attributes:
        robot: The robot.
        frame: The moved frame, None for the tip.
        joints: Indices of the joints that move it.
        lower: Lower limits, (n,), rad or m: the robot's own, and those of the controller's limits.
        upper: Upper limits, the same.
        speed: The largest joint speeds, (n,), finite.
        acceleration: (n,), possibly infinite.
        gain: Largest rate at which the way to a joint limit is used up, 1/s.
        watching: Limits that forbid further configurations, such as collisions.
        lever: Largest motion of any point of the robot for a turn of each joint, m per rad; 1 for joints that slide.
    """

    robot: Robot
    frame: str | None
    joints: NDArray[np.intp]
    lower: Array
    upper: Array
    speed: Array
    acceleration: Array
    gain: float
    watching: tuple[Limit, ...]
    lever: Array

    @classmethod
    def of(cls, robot: Robot, frame: str | None, limits: Sequence[Limit]) -> Self:
        """The space that a controller with these limits allows."""
        ours = [limit for limit in limits if isinstance(limit, JointLimits)]
        chain = robot.chain(frame)
        own = np.where(np.isfinite(robot.velocity_limit), robot.velocity_limit, UNHURRIED)
        speed = np.min([np.full(robot.n, np.inf), *(limit.velocity for limit in ours)], axis=0)
        return cls(
            robot=robot,
            frame=frame,
            joints=np.unique(chain.column[chain.factor != 0]),
            lower=np.max([robot.lower, *(limit.lower for limit in ours)], axis=0),
            upper=np.min([robot.upper, *(limit.upper for limit in ours)], axis=0),
            speed=np.where(np.isfinite(speed), speed, own),
            acceleration=np.min([np.full(robot.n, np.inf), *(limit.acceleration for limit in ours)], axis=0),
            gain=min((limit.gain for limit in ours), default=np.inf),
            watching=tuple(limit for limit in limits if type(limit).spare is not Limit.spare),
            lever=np.where(robot.sliding, 1.0, max(robot.size, 1e-3)),
        )

    @property
    def hurried(self) -> bool:
        """Whether one of the joints that move the frame has an acceleration limit."""
        return bool(np.isfinite(self.acceleration[self.joints]).any())

    def values(self, q: Array) -> Array:
        """Joint values of a configuration, (n,)."""
        return np.asarray(self.robot.joint_values(q))

    def nearest_turn(self, start: Array, goals: Array) -> Array:
        """Joint values of goals, (g, nq) → (g, n), turned by full turns as near to a start, (n,), as limits allow."""
        found = self.robot.joint_values(goals)
        turns = np.where(self.robot.sliding, 0.0, np.round((start - found) / (2 * np.pi)))
        moves = 2 * np.pi * np.stack([turns, turns - 1, turns + 1, 0 * turns])
        tried = found + moves
        inside = (tried >= self.lower) & (tried <= self.upper)
        inside[-1] = True  # unchanged
        chosen = np.argmin(np.where(inside, np.abs(tried - start), np.inf), axis=0)
        nearest = np.take_along_axis(tried, chosen[None], axis=0)[0]
        still = np.setdiff1d(np.arange(self.robot.n), self.joints)
        nearest[:, still] = start[still]
        return np.asarray(nearest)

    def spare(self, x: Array) -> dict[Any, float]:
        """Distances to what is forbidden, of near things only, m, by limit and name."""
        q = self.robot.configuration(x)
        return {
            (number, name): far
            for number, limit in enumerate(self.watching)
            for name, far in limit.spare(self.robot, q, LOOK).items()
        }
