"""Follows a moving target: a function from time to a stack of tasks."""

from __future__ import annotations

import math
import reprlib
from dataclasses import dataclass, field, replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.frame import FrameTask
from robust_ik.control.tasks.pose_difference import pose_error
from robust_ik.control.tasks.stack import Stack, checked_levels
from robust_ik.control.tasks.target_paths import Path
from robust_ik.errors import InputError

STEP = 1e-4
"""Step in time, s, of the differences for the twist of a path. Chosen: rounding adds only 1e-12 m/s to them."""


@dataclass(frozen=True, eq=False)
class Follow:
    """Keep a frame on a path: a function from time in seconds to a stack of tasks.

    `Follow(path, feedforward=True, below=[[PostureTask(robot.rest)]])(t)` is
    `[[FrameTask(path(t), feedforward=twist of the path at t)], [PostureTask(robot.rest)]]`.

    Attributes:
        path: From time in s to a pose, (4, 4).
        gain: Proportional gain, 1/s.
        max_linear: Cap on the position error before the gain, m.
        max_angular: Cap on the rotation error before the gain, rad.
        feedforward: Whether the twist of the path is added, so that the frame does not lag. Without it, it lags by
            speed/gain.
        frame: Link or joint; default the robot's tip.
        below: Lower levels of tasks.
        rows: See `FrameTask`.
        reference: See `FrameTask`.
        weight: See `Task`.
        task: The class of its task: `FrameTask`, or one derived from it, such as `Reach`.
    """

    path: Path
    gain: float = 1.0
    max_linear: float = math.inf
    max_angular: float = math.inf
    feedforward: bool = False
    frame: str | None = None
    below: Stack = ()
    rows: tuple[str, ...] | None = field(default=None, kw_only=True)
    reference: str = field(default="world axes", kw_only=True)
    weight: float = field(default=1.0, kw_only=True)
    task: type[FrameTask] = field(default=FrameTask, kw_only=True)
    _task: FrameTask = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not callable(self.path):
            raise InputError(f"path must be a function from seconds to a pose, got {type(self.path).__name__}")
        if not isinstance(self.feedforward, (bool, np.bool_)):
            raise InputError(
                f"feedforward must be True or False, got {self.feedforward!r}; the twist is the path's own"
            )
        if not (isinstance(self.task, type) and issubclass(self.task, FrameTask)):
            raise InputError(f"task must be FrameTask or Reach, got {reprlib.repr(self.task)}")
        task = self.task(
            np.eye(4),
            gain=self.gain,
            max_linear=self.max_linear,
            max_angular=self.max_angular,
            frame=self.frame,
            rows=self.rows,
            reference=self.reference,
            weight=self.weight,
        )
        object.__setattr__(self, "_task", task)
        object.__setattr__(self, "below", checked_levels("below", self.below))

    def __call__(self, time: float) -> list[list[Task]]:
        """The stack at `time`, s."""
        target = self.path(time)
        twist = path_twist(self.path, time) if self.feedforward else np.zeros(6)
        return [
            [replace(self._task, target=target, feedforward=twist)],
            *map(list, checked_levels("below", self.below)),
        ]

    @property
    def duration(self) -> float | None:
        """Duration of the path, s; None if the path has none."""
        return _duration(self.path)


def path_twist(path: Path, time: float) -> Array:
    """The twist of a path, (6,), linear in m/s then angular in rad/s, world axes, by central differences.

    If the target jumps, a one-sided difference beside the jump is taken: a jump has no speed, and feedback corrects it.
    A path is not evaluated before time 0 or after its duration.

    Args:
        path: From time in s to a pose.
        time: s.
    """
    end = _duration(path)
    here, sides = path(time), []
    if time >= STEP:
        sides.append(pose_error(path(time - STEP), here) / STEP)
    if end is None or not end - STEP < time <= end:
        sides.append(pose_error(here, path(time + STEP)) / STEP)
    if len(sides) < 2:
        return sides[0] if sides else np.zeros(6)
    lengths = np.linalg.norm(sides, axis=1)
    if np.linalg.norm(sides[1] - sides[0]) <= lengths.max() / 2:
        return np.asarray((sides[0] + sides[1]) / 2)
    return sides[int(np.argmin(lengths))]


def _duration(path: Path) -> float | None:
    duration = getattr(path, "duration", None)
    return None if duration is None else float(duration)
