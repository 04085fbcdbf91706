"""Small steps of a self-motion: the arm moves, the tool stands still."""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import RANK_TOLERANCE, full_svd
from robust_ik.robot.robot import Robot

LONGEST, MOST = 0.05, 2 * np.pi
"""Longest step, and the longest way of one command, rad or m.

Chosen: three degrees, after which the tool is brought back with a much smaller move; and one turn.
"""
FARTHEST_BACK = 1.0
"""Largest move back to the pose, as a part of the step. Chosen: beyond it the way back leads to another solution."""


class SelfMotionSteps:
    """Walks along the self-motions of a robot; remembers the direction, so that going on goes on.

    Attributes:
        robot: A robot with a tip.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._last: dict[int, Array] = {}

    def forget(self) -> None:
        """Forgets directions: after the tool has moved."""
        self._last.clear()

    def step(self, q: Array, T: Array, index: int, by: float) -> Array:
        """The configuration after a step along one of the self-motions, within limits.

        Args:
            q: Configuration at which the tool is at T, (nq,).
            T: The pose that is kept, (4, 4).
            index: Which of them, from 0; the weakest come first.
            by: How far, rad or m; at most `LONGEST`.

        Raises:
            InputError: There are fewer self-motions, or no step leads on.
        """
        found = full_svd(self.robot.jacobian(q))
        rank = int((found.s > RANK_TOLERANCE * max(found.s[0], np.finfo(float).tiny)).sum())
        still = found.Vt[rank:]
        if index >= len(still):
            raise InputError(f"there are {len(still)} self-motions here, got number {index + 1}")
        direction = self._directed(still, index)
        values = np.clip(self.robot.joint_values(q) + by * direction, self.robot.lower, self.robot.upper)
        back = self.robot.solve_pose(T, self.robot.configuration(values))
        moved = self.robot.difference(self.robot.configuration(values), back.q)
        if not back.solved or np.linalg.norm(moved) > FARTHEST_BACK * abs(by) + RANK_TOLERANCE:
            raise InputError("this self-motion ends here: at a joint limit, or where no step keeps the tool in place")
        self._last[index] = direction
        return np.asarray(back.q)

    def _directed(self, still: Array, index: int) -> Array:
        """The direction of the null space nearest to the one of the last step, else a vector of its basis."""
        last = self._last.get(index)
        if last is None:
            return np.asarray(still[index])
        along = still.T @ (still @ last)
        size = float(np.linalg.norm(along))
        return np.asarray(along / size if size > 0.5 else still[index])


def parts(by: float) -> list[float]:
    """A way along a self-motion, at most one turn of it, as equal steps that are short enough."""
    way = float(np.clip(by, -MOST, MOST))
    count = max(int(np.ceil(abs(way) / LONGEST)), 1)
    return [way / count] * count
