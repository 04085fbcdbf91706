"""Calms an arm whose joints turn to and fro: its tasks then ask for a smaller share of their speed.

In a closed loop an inverse, a limit, an acceleration limit, noise or lag may make an arm shake although each step keeps
every promise: what a step changes is more than the next one can make up for. Whatever the cause, a smaller gain of the
whole loop ends it. All levels ask for the same share of their velocities, so the directions in which they want to move
stay.

A joint shakes when it has turned back SHAKES times in quick succession, each time after it was faster than PEAK of its
speed limit; then the share falls, and falls faster if joints shake again. The longer the tasks have wanted the same,
the slower a succession counts as quick: an arm may swing with any period. Slower joints count, too, if they turn back
evenly, as noise never makes them. The share stays while the tasks want what they wanted and the arm is where it shook,
since there it would shake again; it grows back as the arm gets away from there, or once the tasks want something else.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.limits import JointLimits, Limit
from robust_ik.control.scaled_levels import Units
from robust_ik.control.tasks import Levels, Task
from robust_ik.kernels.control import control_layout as slots
from robust_ik.kernels.control.control_layout import (
    AGAIN,
    AWAY,
    EVEN,
    FORGETTING,
    GROWTH,
    IN_A_ROW,
    KICK,
    LEAST_SHARE,
    LESS,
    LESS_AGAIN,
    PATIENCE,
    QUIET,
    QUIET_MOST,
    QUIET_STILL,
    REVERSALS,
    SHAKES,
    SMALL,
    STILL,
)
from robust_ik.robot.robot import Robot

PEAK = 0.005
"""A joint that turns back counts if it was faster than this part of its speed limit: half of what is called chatter."""
FAST = 2.0
"""Speed limits above this count as this, rad/s, or units of length a second."""


class Calming:
    """What is remembered of how joints turn back, and the share that follows from it; all in a controller's units.

    Attributes:
        peaks: The speed that a joint must have had for its turning back to count, (n,).
        slowness: How much longer a joint's turnings are remembered for a given speed before them, s / (rad/s), (n,).
        memory: What is remembered, as it lies on the desk of compiled code, see `control_layout.CALM`.
    """

    def __init__(self, peaks: Array, slowness: Array) -> None:
        self.peaks, self.slowness = peaks, slowness
        self.memory = np.zeros(slots.CALMING + slots.REMEMBERED * len(peaks))
        self.memory[[slots.CALM_SHARE, slots.CALM_NOW]] = 1.0
        self._tasks: Levels | None = None

    @classmethod
    def of(cls, robot: Robot, limits: Sequence[Limit], units: Units, *, calm: bool) -> Calming:
        """The calming of an arm within limits; without `calm` none of its turnings count."""
        speeds, accelerations = robot.velocity_limit, np.full(robot.n, np.inf)
        for each in limits:
            if isinstance(each, JointLimits) and len(each.velocity) == robot.n:
                speeds = np.minimum(speeds, each.velocity)
                accelerations = np.minimum(accelerations, each.acceleration)
        told = np.minimum(speeds / units.joints, FAST)
        peaks = PEAK * np.where(told > 0.0, told, FAST) if calm else np.full(robot.n, np.inf)
        return cls(peaks, REVERSALS * units.joints / np.where(accelerations > 0.0, accelerations, np.inf))

    @property
    def share(self) -> float:
        """The share of their velocities that tasks ask for, in (0, 1]."""
        return float(self.memory[slots.CALM_SHARE])

    def watch(self, qdot: Array, dt: float) -> None:
        """Takes note of the velocities of a step, (n,), of length dt, s."""
        self.note(self.memory, qdot, dt)

    def note(self, memory: Array, qdot: Array, dt: float) -> None:
        """Takes note in a memory such as `memory`; `kernels.control.calming.calm` does the same."""
        share = memory[slots.CALM_NOW] = memory[slots.CALM_SHARE]
        extremes, counts, before, way, last, *earlier = memory[slots.CALMING :].reshape(slots.REMEMBERED, -1)
        since = memory[slots.CALM_STILL]
        still = since > STILL
        quiet = max(QUIET_STILL, min(QUIET_MOST, since / PATIENCE)) if still else QUIET
        counts /= 1.0 + dt / (quiet + self.slowness * before)
        turned, speeds = qdot * extremes < 0.0, np.abs(qdot)
        small = _even_turns(earlier, extremes, turned) & bool(still)
        counted = turned & (np.abs(extremes) >= np.where(small, SMALL * self.peaks, self.peaks))
        kicks = still & (np.abs(qdot - last) >= KICK * self.peaks)
        counts[counted] += np.where(kicks, SHAKES, 1.0)[counted]
        before[counted] = np.abs(extremes[counted])
        taken = turned | (speeds > np.abs(extremes))
        extremes[taken] = qdot[taken]
        way += dt * qdot
        last[:] = qdot
        if (counted & (counts >= (SHAKES if share == 1.0 else AGAIN))).any():
            memory[slots.CALM_SHARE] = max(LEAST_SHARE, (LESS if share == 1.0 else LESS_AGAIN) * share)
            memory[[slots.CALM_FREE, slots.CALM_GONE]] = 0.0
            way[:] = 0.0
        elif share < 1.0 and counts.max() < FORGETTING:
            further = max(0.0, float(np.abs(way).max()) - memory[slots.CALM_GONE])
            growth = dt / GROWTH if memory[slots.CALM_FREE] else further / AWAY
            memory[slots.CALM_SHARE] = min(1.0, share + share * growth)
            memory[slots.CALM_GONE] += further

    def look_at(self, tasks: Levels, robot: Robot, dt: float) -> None:
        """Takes note of whether the tasks want something else than in the step before.

        Of tasks whose class has no compiled form nobody knows, so they count as moving.
        """
        if self._tasks is None or _alike(tasks, self._tasks, robot):
            told = all("form" in vars(type(task)) for level in tasks for task in level)
            self.memory[slots.CALM_STILL] = self.memory[slots.CALM_STILL] + dt if told else 0.0
        else:
            self.memory[[slots.CALM_STILL, slots.CALM_FREE]] = 0.0, 1.0
        self._tasks = tasks


def _even_turns(earlier: Sequence[Array], extremes: Array, turned: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Notes the largest velocities before joints turned back; which have turned back evenly for long, (n,)."""
    last, before, row = earlier
    even = np.abs(extremes - before) <= EVEN * np.abs(extremes)
    row[turned] = np.where(even, row + 1.0, 0.0)[turned]
    before[turned], last[turned] = last[turned], extremes[turned]
    return np.asarray(row >= IN_A_ROW)


def _alike(tasks: Levels, others: Levels, robot: Robot) -> bool:
    """Whether stacks have the same tasks, or such with the same numbers."""
    if [len(level) for level in tasks] != [len(level) for level in others]:
        return False
    pairs = [pair for one, other in zip(tasks, others) for pair in zip(one, other)]
    return all(a is b or (type(a) is type(b) and _equal(a, b, robot)) for a, b in pairs)


def _equal(task: Task, other: Task, robot: Robot) -> bool:
    """Whether two tasks of a kind have the same numbers."""
    return all(np.array_equal(task.number(robot, each), other.number(robot, each)) for each in task.numbers)
