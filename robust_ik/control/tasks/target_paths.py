"""Moving targets: each path is a function from time in seconds to a pose."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, alone, as_measures, checked_parameter, checked_rigid, readonly
from robust_ik.errors import InputError

if TYPE_CHECKING:
    from scipy.spatial.transform import Slerp

Path = Callable[[float], Array]

RIGHT_ANGLE = 1e-9
"""Largest deviation from a right angle, rad."""
LATEST = 1e12
"""Times within this range, s, are accepted without further checks."""


def checked_time(time: object) -> float:
    """A time in seconds, checked quickly enough for every control step.

    Raises:
        InputError: It is not a finite number.
    """
    return time if type(time) is float and -LATEST < time < LATEST else checked_parameter("time", time)


def _one_pose(start: ArrayLike) -> Array:
    return readonly(alone(checked_rigid(start, "start"), "start", 2))


def _one_point(value: ArrayLike, name: str) -> Array:
    return readonly(alone(as_measures(value, name, (3,)), name, 1))


@dataclass(frozen=True, eq=False)
class Keypoints:
    """Poses held one after another; the target jumps from each to the next.

    Attributes:
        poses: (k, 4, 4).
        seconds: Time for which each is held, s.
    """

    poses: Array
    seconds: float

    def __post_init__(self) -> None:
        poses = checked_rigid(self.poses, "poses")
        if poses.ndim != 3 or len(poses) == 0:
            raise InputError(f"poses must be a sequence of at least one pose, (k, 4, 4), got shape {poses.shape}")
        object.__setattr__(self, "poses", readonly(poses))
        checked_parameter("seconds", self.seconds, above=0)

    def __call__(self, time: float) -> Array:
        """The pose wanted at `time`; after the end, the last one."""
        time = checked_time(time)
        # A sample that rounding puts just before the jump belongs to the next pose.
        index = math.floor(min(max(time / self.seconds + 1e-9, 0.0), len(self.poses) - 1.0))
        return np.asarray(self.poses[index])

    @property
    def duration(self) -> float:
        """Duration of all of them, s."""
        return len(self.poses) * self.seconds


@dataclass(frozen=True, eq=False)
class OutAndBack:
    """A straight line to a point and back, with constant orientation and smooth speed, and a pause at either end.

    Attributes:
        start: Pose at the start, (4, 4).
        goal: Far end, (3,), m.
        travel: Time for one way, s.
        pause: Pause at the far end, s.
        settle: Pause at the start after the return, s.
    """

    start: Array
    goal: Array
    travel: float = 4.0
    pause: float = 1.0
    settle: float = 2.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", _one_pose(self.start))
        object.__setattr__(self, "goal", _one_point(self.goal, "goal"))
        checked_parameter("travel", self.travel, above=0)
        checked_parameter("pause", self.pause, above=0)
        checked_parameter("settle", self.settle, above=0)

    def __call__(self, time: float) -> Array:
        """The pose wanted at `time`."""
        time = checked_time(time)
        out = min(max(time / self.travel, 0.0), 1.0)
        back = min(max((time - self.travel - self.pause) / self.travel, 0.0), 1.0)
        share = (math.cos(math.pi * back) - math.cos(math.pi * out)) / 2
        pose = np.array(self.start)
        pose[:3, 3] += share * (self.goal - pose[:3, 3])
        return pose

    @property
    def duration(self) -> float:
        """Duration, s."""
        return 2 * self.travel + self.pause + self.settle


@dataclass(frozen=True, eq=False)
class Line:
    """A straight line at constant speed, with constant orientation; it stops at its end.

    Attributes:
        start: Pose at the start, (4, 4).
        goal: Its end, (3,), m.
        speed: m/s.
    """

    start: Array
    goal: Array
    speed: float = 0.1

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", _one_pose(self.start))
        object.__setattr__(self, "goal", _one_point(self.goal, "goal"))
        checked_parameter("speed", self.speed, above=0)
        if self.duration == 0:
            raise InputError("goal must be another point than where the line starts")

    def __call__(self, time: float) -> Array:
        """The pose wanted at `time`."""
        time = checked_time(time)
        pose = np.array(self.start)
        pose[:3, 3] += min(max(time / self.duration, 0.0), 1.0) * (self.goal - pose[:3, 3])
        return pose

    @property
    def duration(self) -> float:
        """Duration, s."""
        return float(np.linalg.norm(self.goal - self.start[:3, 3])) / self.speed


@dataclass(frozen=True, eq=False)
class Circle:
    """A circle, or an arc of one, at constant speed, with constant orientation.

    Attributes:
        start: Pose at the start, (4, 4).
        centre: (3,), m.
        normal: Axis of the turn, (3,), perpendicular to the radius; the turn is positive about it.
        period: Time for one turn, s.
        turns: Number of turns; a fraction for an arc.
    """

    start: Array
    centre: Array
    normal: Array
    period: float = 4.0
    turns: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", _one_pose(self.start))
        object.__setattr__(self, "centre", _one_point(self.centre, "centre"))
        normal = _one_point(self.normal, "normal")
        length = float(np.linalg.norm(normal))
        if length == 0:
            raise InputError("normal must not be zero")
        object.__setattr__(self, "normal", readonly(normal / length))
        checked_parameter("period", self.period, above=0)
        checked_parameter("turns", self.turns, above=0)
        radius = self.start[:3, 3] - self.centre
        if abs(radius @ self.normal) > RIGHT_ANGLE * max(float(np.linalg.norm(radius)), RIGHT_ANGLE):
            raise InputError("normal must be at right angles to the line from the centre to the start")

    def __call__(self, time: float) -> Array:
        """The pose wanted at `time`."""
        time = checked_time(time)
        pose, angle = np.array(self.start), 2 * math.pi * min(time, self.duration) / self.period
        radius = pose[:3, 3] - self.centre
        turned = math.cos(angle) * radius + math.sin(angle) * np.cross(self.normal, radius)
        pose[:3, 3] = self.centre + turned
        return pose

    @property
    def duration(self) -> float:
        """Duration of all turns, s."""
        return self.turns * self.period


@dataclass(frozen=True, eq=False)
class Sinusoid:
    """A swing about a pose along a line, with constant orientation: centre + amplitude · sin(2π t/period).

    Attributes:
        centre: The pose in the middle, where it begins, (4, 4).
        amplitude: Vector from the centre to the farthest point, (3,), m, world axes.
        period: Time for one swing, s.
        swings: Number of swings.
    """

    centre: Array
    amplitude: Array
    period: float = 10.0
    swings: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", readonly(checked_rigid(self.centre, "centre")))
        object.__setattr__(self, "amplitude", _one_point(self.amplitude, "amplitude"))
        checked_parameter("period", self.period, above=0)
        checked_parameter("swings", self.swings, above=0)

    def __call__(self, time: float) -> Array:
        """The pose wanted at `time`."""
        time = checked_time(time)
        pose = np.array(self.centre)
        pose[:3, 3] += self.amplitude * math.sin(2 * math.pi * time / self.period)
        return pose

    @property
    def duration(self) -> float:
        """Duration of all swings, s."""
        return self.swings * self.period


@dataclass(frozen=True, eq=False)
class Turning:
    """The positions of another path, with an orientation that turns the short way to `goal` at constant speed.

    Attributes:
        path: A path with a duration.
        goal: Orientation at its end, (3, 3).
    """

    path: Line | Circle
    goal: Array
    _between: Slerp = field(init=False, repr=False)

    def __post_init__(self) -> None:
        from scipy.spatial.transform import Rotation, Slerp  # slow to import: only if it is needed

        if not (hasattr(self.path, "start") and hasattr(self.path, "duration") and callable(self.path)):
            raise InputError(f"path must be a path with a start and a duration, such as a Line, got {self.path!r}")
        whole = np.eye(4)
        whole[:3, :3] = alone(as_measures(self.goal, "goal", (3, 3)), "goal", 2)
        object.__setattr__(self, "goal", readonly(checked_rigid(whole, "goal")[:3, :3]))
        ends = Rotation.from_matrix(np.stack([self.path.start[:3, :3], self.goal]))
        object.__setattr__(self, "_between", Slerp([0.0, 1.0], ends))

    def __call__(self, time: float) -> Array:
        """The pose wanted at `time`."""
        time = checked_time(time)
        pose = np.array(self.path(time))
        pose[:3, :3] = self._between(min(max(time / self.duration, 0.0), 1.0)).as_matrix()
        return pose

    @property
    def duration(self) -> float:
        """Duration of the path, s."""
        return self.path.duration


def pose(position: ArrayLike, rpy: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """A homogeneous transform from a position in m and roll, pitch, yaw in rad about fixed x, y, z axes, (4, 4)."""
    x, y, z = _one_point(rpy, "rpy")
    cx, sx, cy, sy, cz, sz = math.cos(x), math.sin(x), math.cos(y), math.sin(y), math.cos(z), math.sin(z)
    Rx = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    Ry = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    Rz = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rz @ Ry @ Rx, _one_point(position, "position")
    return T
