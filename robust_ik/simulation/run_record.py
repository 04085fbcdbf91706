"""The record of a run while it is made: what costs time is computed for many steps at once."""

from __future__ import annotations

from typing import Any

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.control.compiled_loop import StepReports, UnreadReport
from robust_ik.control.resolution import LazyResolution, Resolution
from robust_ik.control.resolvers import Resolver, TaskPriority
from robust_ik.control.tasks import FrameTask, Levels, pose_error
from robust_ik.control.velocity_controller import VelocityController
from robust_ik.kinematics.svd import length, svd
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.simulation.trajectory import Trajectory

AT_ONCE = 250
"""Steps whose reports are made at once. Chosen: some 5 MB for an arm; more are hardly faster."""
LEVELS = ("scale", "residual", "manipulability", "smallest_level_sigma", "corank", "algorithmic")
"""What is recorded of each level."""


class RunRecord:
    """The arrays of a run, filled during the simulation."""

    def __init__(self, controller: VelocityController, steps: int, dt: float, stack: Levels) -> None:
        self._controller, self._robot, self._dt, robot = controller, controller.robot, dt, controller.robot
        task = watched(stack)
        self._stack, self._watched = stack, task
        self._frame = (None if task is None else task.frame) or robot.tip or robot.frames[-1]
        self._done, self._settled = 0, 0
        self._seconds = np.empty(steps)
        self._q, self._qdot = np.empty((steps, robot.nq)), np.empty((steps, robot.n))
        self._target, self._pose = np.empty((steps, 4, 4)), np.empty((steps, 4, 4))
        self._error = np.zeros((steps, 6))
        self._sigma = np.empty((steps, min(len(robot.rows), robot.n)))
        self._levels = {name: np.full((steps, 0), np.nan) for name in LEVELS}
        self._calmed = np.ones(steps)
        self._status = np.empty(steps, dtype=object)
        self._active: list[tuple[str, ...]] = []
        self._contradictions: list[tuple[str, ...]] = []
        self._tasks: list[FrameTask | None] = []
        self._resolutions: list[Resolution] = []

    def write(self, seconds: float, q: Array, stack: Levels, resolution: Resolution) -> None:
        """Records a step.

        Args:
            seconds: The time it took.
            q: The configuration from which it was made, (nq,).
            stack: Its stack.
            resolution: Its result.
        """
        i = self._done
        self._seconds[i], self._q[i], self._qdot[i] = seconds, q, resolution.qdot
        if stack is not self._stack:
            self._stack, self._watched = stack, watched(stack)
        self._tasks.append(self._watched)
        self._resolutions.append(resolution)
        self._done += 1
        if len(self._tasks) == AT_ONCE:
            self._settle()

    def _settle(self) -> None:
        """Computes what is recorded of the steps since the last time."""
        if not self._tasks:
            return
        steps = slice(self._settled, self._done)
        q = self._q[steps]
        self._pose[steps], self._target[steps], self._error[steps] = self._where(q, self._tasks)
        self._sigma[steps] = svd(self._robot.jacobian(q, self._frame)).s
        begin = 0
        while begin < len(self._resolutions):  # of one program each
            end, reports = self._reports(begin)
            if reports is None:
                self._write_one(self._settled + begin, self._resolutions[begin])
            else:
                self._write_many(self._settled + begin, reports)
            begin = end
        self._settled, self._tasks, self._resolutions = self._done, [], []

    def _reports(self, begin: int) -> tuple[int, StepReports | None]:
        """The reports of steps from `begin` on of one program, and where they end; None if the first has its own."""
        unread: list[UnreadReport] = []
        for each in self._resolutions[begin:]:
            made = each.unread if isinstance(each, LazyResolution) else None
            if not isinstance(made, UnreadReport) or made.rows is not None:
                break
            if unread and not made.left.is_like(unread[0].left):
                break
            unread.append(made)
        reports = self._controller.compiled.reports(unread) if unread else None
        return begin + (1 if reports is None else len(unread)), reports

    def _write_many(self, at: int, reports: StepReports) -> None:
        count, levels = reports.scale.shape
        for name in LEVELS:
            self._widen(name, levels)
            self._levels[name][at : at + count, :levels] = getattr(reports, name)
        self._calmed[at : at + count] = reports.calmed
        self._status[at : at + count] = reports.status
        self._active += reports.active
        self._contradictions += reports.contradictions

    def _write_one(self, at: int, resolution: Resolution) -> None:
        self._calmed[at] = resolution.calmed
        self._status[at] = resolution.status
        self._active.append(resolution.active)
        self._contradictions.append(resolution.contradictions)
        for index, level in enumerate(resolution.levels):
            smallest = level.sigma[-1] if len(level.sigma) else np.nan
            residual = length(level.residual)
            values = (level.scale, residual, level.manipulability, smallest, level.corank, level.algorithmic)
            for name, value in zip(LEVELS, values):
                self._widen(name, index + 1)
                self._levels[name][at, index] = value

    def _widen(self, name: str, levels: int) -> None:
        """Makes room for so many levels."""
        missing = levels - self._levels[name].shape[1]
        if missing > 0:
            self._levels[name] = np.pad(self._levels[name], ((0, 0), (0, missing)), constant_values=np.nan)

    def _where(self, q: Array, tasks: list[FrameTask | None]) -> tuple[Array, Array, Array]:
        """Poses, targets and errors, (K, 6), of the watched frame at q, (K, nq)."""
        pose = np.asarray(self._robot.pose(q, self._frame))
        target, kept = pose.copy(), np.zeros((len(q), 6), dtype=bool)
        rows: dict[tuple[object, ...], list[int]] = {}
        for k, task in enumerate(tasks):
            if task is not None and (task.frame or self._frame) == self._frame:
                target[k] = task.target
                rows.setdefault((task.rows, task.reference, task.frame), []).append(k)
        for steps in rows.values():
            kept[np.ix_(steps, self._rows_of(tasks[steps[0]]))] = True
        return pose, target, np.where(kept, pose_error(pose, target), 0.0)

    def _rows_of(self, task: FrameTask | None) -> list[int]:
        """Indices of the rows in which the error of a task is recorded."""
        if task is None or task.reference != "world axes":
            return list(range(6))
        own = self._robot.rows if task.frame in (None, self._robot.tip) else ROWS
        return [ROWS.index(row) for row in task.rows or own]

    def trajectory(self, q: Array, stack: Levels) -> Trajectory:
        """The run.

        Args:
            q: The configuration after the last step, (nq,).
            stack: The stack then.
        """
        self._settle()
        arrays: dict[str, Any] = {
            "time": np.arange(self._done) * self._dt, "q": self._q, "qdot": self._qdot, "target": self._target,
            "pose": self._pose, "error": self._error, "sigma": self._sigma, "calmed": self._calmed, **self._levels,
        }  # fmt: skip
        self._status.setflags(write=False)
        resolver = self._controller.resolver
        return Trajectory(
            robot=self._robot,
            resolver=resolver,
            name=run_name(resolver),
            **{name: readonly(values) for name, values in arrays.items()},
            status=self._status,
            active=tuple(self._active),
            contradictions=tuple(self._contradictions),
            seconds_per_step=float(np.median(self._seconds)),
            final_q=readonly(q),
            final_error=readonly(self._where(q[None], [watched(stack)])[2][0]),
        )


def watched(stack: Levels) -> FrameTask | None:
    """The first task with a target pose, or None."""
    return next((task for level in stack for task in level if isinstance(task, FrameTask)), None)


def run_name(resolver: Resolver) -> str:
    """The name of a run: the inverse, for a plain `TaskPriority` with one inverse for all levels; else the resolver."""
    if isinstance(resolver, TaskPriority) and len(resolver.inverses) == 1:
        return type(resolver.inverses[0]).__name__
    return type(resolver).__name__
