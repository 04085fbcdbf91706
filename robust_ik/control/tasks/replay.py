"""Plays back recorded twists: a function from time to a stack of tasks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from robust_ik.checks import Array, as_measures, readonly
from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.stack import Stack, checked_levels
from robust_ik.control.tasks.target_paths import checked_time
from robust_ik.control.tasks.twist import TwistTask
from robust_ik.errors import InputError


@dataclass(frozen=True, eq=False)
class Replay:
    """Commands as an operator gave them: a function from time in seconds to a stack, a `TwistTask` above `below`.

    Between samples the twist is interpolated linearly; before the first and after the last it is zero. There is no
    target, so that errors in following it are not corrected.

    Attributes:
        times: Times of the samples, (k,), s, increasing.
        twists: Twists commanded then, (k, 6), linear in m/s then angular in rad/s.
        frame: Link or joint; default the robot's tip.
        reference: See `TwistTask`.
        below: Lower levels of tasks.
    """

    times: Array
    twists: Array
    frame: str | None = None
    reference: Literal["local_world_aligned", "local"] = "local_world_aligned"
    below: Stack = field(default=(), kw_only=True)

    def __post_init__(self) -> None:
        times = as_measures(self.times, "times", (None,))
        if times.ndim != 1 or len(times) < 2 or not (np.diff(times) > 0).all():
            raise InputError(f"times must be at least two that increase, (k,), got {times.tolist()[:10]}")
        twists = as_measures(self.twists, "twists", (len(times), 6))
        if twists.ndim != 2:
            raise InputError(f"twists must have shape ({len(times)}, 6), got {twists.shape}")
        TwistTask(np.zeros(6), self.frame, self.reference)
        object.__setattr__(self, "times", readonly(times))
        object.__setattr__(self, "twists", readonly(twists))
        object.__setattr__(self, "below", checked_levels("below", self.below))

    def __call__(self, time: float) -> list[list[Task]]:
        """The stack at `time`, s."""
        task = TwistTask(self.twist(time), self.frame, self.reference)
        return [[task], *map(list, checked_levels("below", self.below))]

    def twist(self, time: float) -> Array:
        """The twist commanded at `time`, (6,)."""
        return np.array(
            [np.interp(checked_time(time), self.times, column, left=0.0, right=0.0) for column in self.twists.T]
        )

    @property
    def duration(self) -> float:
        """Time of the last sample, s."""
        return float(self.times[-1])
