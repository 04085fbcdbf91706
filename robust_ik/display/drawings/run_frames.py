"""A run, reduced to the frames of a film."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.simulation.trajectory import Trajectory

FRAMES_PER_SECOND = 30.0
"""Frames per second, as in a video. Chosen: the viewer interpolates between them; more only make pages larger."""
MOST_FRAMES = 3000
"""Most frames of a run.

Chosen: 100 s at that rate; longer runs have fewer frames per second, so that pages stay small.
"""


@dataclass(frozen=True, eq=False)
class Frames:
    """A run at the times of the frames.

    Attributes:
        run: The run.
        rows: Indices of the run's rows that are shown, (F,), at least two.
        times: Seconds from the start, (F,).
        tip: Tip positions, (F, 3).
    """

    run: Trajectory
    rows: NDArray[np.int_]
    times: Array
    tip: Array

    @classmethod
    def of(cls, run: Trajectory) -> Frames:
        """About thirty rows a second, including the last one."""
        count, duration = len(run.time), float(run.time[-1] - run.time[0])
        wanted = min(max(round(duration * FRAMES_PER_SECOND), 1), count - 1, MOST_FRAMES)
        rows = np.unique(np.linspace(0, count - 1, wanted + 1).round().astype(int))
        times = run.time[rows] - run.time[0]
        if len(rows) == 1:
            rows, times = np.repeat(rows, 2), np.array([0.0, 1.0])
        return cls(run, rows, times, run.pose[rows, :3, 3])

    @property
    def q(self) -> Array:
        """Configurations, (F, nq)."""
        return self.run.q[self.rows]

    @property
    def target(self) -> Array:
        """Target poses, (F, 4, 4)."""
        return self.run.target[self.rows]

    @property
    def jacobians(self) -> Array:
        """Task Jacobians, (F, m, n)."""
        return self.run.robot.jacobian(self.q)
