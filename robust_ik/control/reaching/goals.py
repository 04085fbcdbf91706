"""Goals of a plan: configurations that solve a pose, or the closest one."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.reaching.search_space import Space
from robust_ik.control.tasks.frame import FrameTask
from robust_ik.control.tasks.pose_feedback import turned
from robust_ik.control.tasks.task_arguments import task_rows
from robust_ik.pose_ik import PoseResult, PoseSolver

AS_GOOD = 1.002
"""Factor on the least distance from the target up to which a configuration is as good as the closest."""
MANY = 32
"""Number of solutions that are looked for."""


@dataclass(frozen=True, eq=False)
class Goals:
    """Goals of a plan.

    Attributes:
        points: Joint values, (g, n).
        error: Their distance from the target: m, and rad; zero for solutions.
    """

    points: Array
    error: tuple[float, float]


class GoalFinder:
    """Solves the pose that a `FrameTask` wants, within the limits of a space."""

    def __init__(self, space: Space) -> None:
        self.space = space
        self._made: tuple[Any, PoseSolver] | None = None

    def near(self, task: FrameTask, q: Array) -> PoseResult:
        """The solution found by a search from q, or the closest configuration."""
        solver, target = self._solver(task)
        return solver.solve(target, q)

    def closest(self, task: FrameTask, q: Array) -> PoseResult:
        """The same with thorough effort."""
        solver, target = self._solver(task)
        return solver.solve(target, q, effort="thorough")

    def all(self, task: FrameTask, x: Array) -> Goals:
        """Many solutions, or the closest configuration, each turned by full turns as near to x, (n,), as possible."""
        solver, target = self._solver(task)
        q = self.space.robot.configuration(x)
        near = solver.solve(target, q)
        if near.solved:
            several = solver.solve(target, q, solutions=MANY)
            return Goals(self.space.nearest_turn(x, np.concatenate([near.q[None], several.solutions])), (0.0, 0.0))
        closest = self.closest(task, q)
        if closest.solved:
            return Goals(self.space.nearest_turn(x, closest.solutions), (0.0, 0.0))
        as_good = self.missed(near) <= AS_GOOD * self.missed(closest)
        points = np.stack([near.q, closest.q] if as_good else [closest.q])
        return Goals(self.space.nearest_turn(x, points), closest.error)

    def missed(self, found: PoseResult) -> float:
        """Distance of a result from its target, m, with rad times a length; zero for solutions."""
        return 0.0 if found.solved else math.hypot(found.error[0], self.space.robot.length_scale * found.error[1])

    def _solver(self, task: FrameTask) -> tuple[PoseSolver, Array]:
        """The solver for the task's rows, and its target."""
        space, in_world = self.space, task.reference == "world axes"
        rows = task_rows(space.robot, task.frame, task.rows, world_axes=in_world)
        if in_world or len(rows) == 6:
            key: Any = rows
            if self._made is None or self._made[0] != key:
                self._made = key, self._plain(rows)
            return self._made[1], task.target
        turn = task.target[:3, :3].T
        key = rows, turn.tobytes()
        if self._made is None or self._made[0] != key:
            plain = self._plain(rows)
            rotations, origins = plain.chain.rotations.copy(), plain.chain.origins.copy()
            rotations[0], origins[0] = turn @ rotations[0], turn @ origins[0]
            self._made = key, replace(plain, chain=replace(plain.chain, rotations=rotations, origins=origins))
        return self._made[1], turned(turn, task.target)

    def _plain(self, rows: tuple[str, ...]) -> PoseSolver:
        space = self.space
        plain = space.robot.pose_solver(space.frame, rows)
        if (space.lower == plain.lower).all() and (space.upper == plain.upper).all():
            return plain
        return replace(plain, lower=space.lower, upper=space.upper)
