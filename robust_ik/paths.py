"""Targets that move: each path is a function from time in seconds to a pose."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.errors import InputError
from robust_ik.linalg import Array, as_array, readonly

Path = Callable[[float], Array]


@dataclass(frozen=True, eq=False)
class Keypoints:
    """Poses held one after another, the target jumping from each to the next.

    Attributes:
        poses: (k, 4, 4).
        seconds: How long each is held.
    """

    poses: Array
    seconds: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "poses", readonly(as_array(self.poses, "poses", (None, 4, 4))))
        _check_positive("seconds", self.seconds)

    def __call__(self, time: float) -> Array:
        """The pose wanted at `time`; the last one from then on."""
        # A sample that rounding puts just before the switch belongs to the next keypoint.
        index = math.floor(time / self.seconds + 1e-9)
        return np.asarray(self.poses[min(max(index, 0), len(self.poses) - 1)])

    @property
    def duration(self) -> float:
        """Seconds for all of them."""
        return len(self.poses) * self.seconds


@dataclass(frozen=True, eq=False)
class OutAndBack:
    """A straight line to a point and back, orientation held, smooth in speed, with a stop at the far end and after.

    Attributes:
        start: Pose to leave from and to return to, (4, 4).
        goal: Far end, (3,), m.
        travel: Seconds for one way.
        pause: Seconds at the far end.
        settle: Seconds at the start again.
    """

    start: Array
    goal: Array
    travel: float = 4.0
    pause: float = 1.0
    settle: float = 2.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", readonly(as_array(self.start, "start", (4, 4))))
        object.__setattr__(self, "goal", readonly(as_array(self.goal, "goal", (3,))))
        _check_positive("travel", self.travel)
        _check_positive("pause", self.pause)
        _check_positive("settle", self.settle)

    def __call__(self, time: float) -> Array:
        """The pose wanted at `time`."""
        out = min(max(time / self.travel, 0.0), 1.0)
        back = min(max((time - self.travel - self.pause) / self.travel, 0.0), 1.0)
        share = (math.cos(math.pi * back) - math.cos(math.pi * out)) / 2
        pose = np.array(self.start)
        pose[:3, 3] += share * (self.goal - pose[:3, 3])
        return pose

    @property
    def duration(self) -> float:
        """Seconds for all of it."""
        return 2 * self.travel + self.pause + self.settle


def pose(position: ArrayLike, rpy: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """A homogeneous transform from a position in m and roll, pitch, yaw in rad about fixed x, y, z axes, (4, 4)."""
    x, y, z = as_array(rpy, "rpy", (3,))
    cx, sx, cy, sy, cz, sz = math.cos(x), math.sin(x), math.cos(y), math.sin(y), math.cos(z), math.sin(z)
    Rx = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    Ry = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    Rz = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rz @ Ry @ Rx, as_array(position, "position", (3,))
    return T


def _check_positive(name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0):
        raise InputError(f"{name} must be a positive number of seconds, got {value!r}")
