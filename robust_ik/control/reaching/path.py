"""A path through joint space, and how fast it can be followed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.bounds import Bounds
from robust_ik.control.limits.joint_limits import braking_speed
from robust_ik.control.reaching.search_space import Space
from robust_ik.control.tasks.frame import FrameTask
from robust_ik.control.tasks.task_arguments import indices, task_rows
from robust_ik.kinematics.svd import norms

FINE, LEAST_SAMPLES, MOST_SAMPLES = 0.04, 6, 120
"""Spacing of speed samples on a leg, rad or m of the joint that goes furthest; least and most number of samples."""
KEPT = 0.97
"""Fraction of a cap on the tool's speed that is used for planning: between samples the limit may be lower."""
BRAKING = 0.8
"""Fraction of the acceleration limits that is used for planning."""
LANDING = 2.0
"""Steps in which an arm without acceleration limits would reach its goal; so it comes to rest in more than one."""
AT_ONCE = 1e6
"""Speed of a leg of length zero, 1/s."""
STILL = 1e-12
"""Joints that go less far than this, rad or m, do not move."""


@dataclass(frozen=True, eq=False)
class Caps:
    """Caps on the speed of a tool.

    Attributes:
        linear: m/s, possibly infinite.
        angular: rad/s, possibly infinite.
        rows: Indices of the rows that count, in a twist along `axes`.
        axes: Columns of (3, 3); None for the world's.
    """

    linear: float
    angular: float
    rows: tuple[int, ...]
    axes: Array | None

    @classmethod
    def of(cls, task: FrameTask, space: Space) -> Caps:
        """The caps of a task's own servo."""
        in_world = task.reference == "world axes"
        rows = task_rows(space.robot, task.frame, task.rows, world_axes=in_world)
        axes = None if in_world else task.target[:3, :3]
        return cls(task.gain * task.max_linear, task.gain * task.max_angular, tuple(indices(rows)), axes)

    def share(self, twists: Array) -> Array:
        """The share of twists, (..., 6) in world axes, that the caps allow, (...): possibly more than 1 or infinite."""
        if self.axes is not None:
            twists = np.concatenate([twists[..., :3] @ self.axes, twists[..., 3:] @ self.axes], axis=-1)
        kept = np.zeros(6)
        kept[list(self.rows)] = 1.0
        linear, angular = (norms((kept * twists)[..., part]) for part in (slice(3), slice(3, 6)))
        with np.errstate(divide="ignore", invalid="ignore"):
            found = np.minimum(self.linear / linear, self.angular / angular)
        return np.where(np.isnan(found), np.inf, found)


@dataclass(frozen=True, eq=False)
class Path:
    """Straight legs through joint space, followed as fast as joints and caps allow.

    With acceleration limits every leg begins and ends at rest.

    Attributes:
        space: The space of joint values.
        points: (k + 1, n), joint values.
        caps: Caps on the tool's speed.
    """

    space: Space
    points: Array
    caps: Caps

    @property
    def legs(self) -> int:
        """Number of legs."""
        return len(self.points) - 1

    @property
    def goal(self) -> Array:
        """The last point, (n,)."""
        return np.asarray(self.points[-1])

    def to(self, goal: Array) -> Path:
        """The same path with another end."""
        return Path(self.space, np.concatenate([self.points[:-1], goal[None]]), self.caps)

    def way(self, leg: int) -> Array:
        """The difference between the ends of a leg, (n,)."""
        return np.asarray(self.points[leg + 1] - self.points[leg])

    def at(self, leg: int, s: float) -> Array:
        """The point of a leg at s in [0, 1]."""
        return np.asarray(self.points[leg] + s * self.way(leg))

    @property
    def duration(self) -> float:
        """The least time that it takes, s."""
        return sum(self._seconds(leg) for leg in range(self.legs))

    def _seconds(self, leg: int) -> float:
        s, speed = self.profiles[leg]
        hurry = self._hurry(leg)
        if np.isfinite(hurry):  # starts from rest
            speed = np.minimum(speed, np.sqrt(2 * hurry * s))
        return float(np.sum(2 * np.diff(s) / np.maximum(speed[1:] + speed[:-1], 1e-9)))

    def _hurry(self, leg: int) -> float:
        """The largest acceleration of s that joints allow, 1/s²."""
        way = np.abs(self.way(leg))
        moving = way > STILL
        return BRAKING * float(np.min(self.space.acceleration[moving] / way[moving], initial=np.inf))

    @cached_property
    def profiles(self) -> tuple[tuple[Array, Array], ...]:
        """For each leg samples of s, with the largest speeds ṡ, 1/s, from which all limits can still be kept."""
        return tuple(self._profile(leg) for leg in range(self.legs))

    def _profile(self, leg: int) -> tuple[Array, Array]:
        way, robot = self.way(leg), self.space.robot
        moving = np.abs(way) > STILL
        if not moving.any():
            return np.array([0.0, 1.0]), np.full(2, AT_ONCE)
        count = int(np.clip(np.abs(way).max() / FINE, LEAST_SAMPLES, MOST_SAMPLES)) + 1
        s = np.linspace(0.0, 1.0, count)
        q = robot.configuration(self.points[leg] + s[:, None] * way)
        twists = robot.chain(self.space.frame).jacobians(q, "local_world_aligned") @ way
        speed = np.minimum(
            KEPT * self.caps.share(twists), float((self.space.speed[moving] / np.abs(way[moving])).min())
        )
        hurry = self._hurry(leg)
        if np.isfinite(hurry):
            speed[-1] = 0.0
            for i in range(count - 2, -1, -1):
                speed[i] = min(speed[i], float(np.sqrt(speed[i + 1] ** 2 + 2 * hurry * (s[i + 1] - s[i]))))
        return s, speed

    def speed(self, leg: int, s: float, dt: float) -> float:
        """The speed ṡ for the next step, 1/s, without regard to bounds."""
        places, speeds = self.profiles[leg]
        room, hurry = 1.0 - s, self._hurry(leg)
        if not np.isfinite(hurry):
            last = leg + 1 == self.legs
            return min(float(np.interp(s, places, speeds)), room / (LANDING * dt if last else dt))
        planned = float(np.sqrt(np.interp(s, places, speeds**2)))
        braking = braking_speed(np.array([room]), np.array([hurry / BRAKING]), dt)
        # In the last interval the samples fall to zero; braking in steps is more exact there.
        return float(min(planned if s < places[-2] else speeds[-2], braking[0]))


def fitting_speed(wanted: float, way: Array, aside: Array, bounds: Bounds) -> float:
    """The ṡ nearest to the wanted one for which way · ṡ + aside is inside bounds; the wanted one if there is none.

    Args:
        wanted: 1/s, ≥ 0.
        way: Change of the joints for s from 0 to 1, (n,).
        aside: Further joint velocities, (n,).
        bounds: Bounds on joint velocities.
    """
    slopes = np.concatenate([way, -way, -(bounds.rows @ way)])
    room = np.concatenate([bounds.upper - aside, aside - bounds.lower, bounds.rows @ aside - bounds.floor])
    rising, falling = slopes > STILL, slopes < -STILL
    most = float(np.min(room[rising] / slopes[rising], initial=np.inf))
    least = float(np.max(room[falling] / slopes[falling], initial=-np.inf))
    return max(0.0, min(max(wanted, least), most)) if least <= most else wanted
