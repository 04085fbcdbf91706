"""What lies between two solutions of a plan: the motion is made finer until it is on the path, or it is none.

Arrays only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.paths.layer_solver import LayerSolver
from robust_ik.paths.path_error import path_error
from robust_ik.paths.pose_path import PosePath

BETWEEN = np.arange(1, 10) / 10
"""Where a motion is looked at between two of its configurations."""
MOST_HALVINGS = 14
"""How often a step between two solutions is halved at most."""
CLOSE = 0.5
"""How close configurations come to the path, of the accuracy: the rest is left to what lies between them."""
BENT, SHORTER = 3.0, 0.8
"""A part of a step that was halved d times moves joints by BENT · SHORTER^d of the whole step at most, or it is a jump.

Chosen: at a fold joints move with the root of the place, so that parts become shorter by 0.71; a jump stays as it is.
"""


@dataclass(frozen=True, eq=False)
class Between:
    """Looks between configurations.

    Attributes:
        path: The poses.
        solver: The arm.
        accuracy: How far the frame may leave the path, m, and rad times the length scale.
    """

    path: PosePath
    solver: LayerSolver
    accuracy: float

    def off(self, s: Array, values: Array) -> Array:
        """How far the frame leaves the path between neighbours, (m,) and (m, n) → (m − 1,)."""
        places = s[:-1, None] + np.diff(s)[:, None] * BETWEEN
        middle = values[:-1, None] + np.diff(values, axis=0)[:, None] * BETWEEN[:, None]
        targets = self.path.at(places.ravel()).reshape(*places.shape, 4, 4)
        rows, poses = self.solver.branches.rows, self.solver.poses(middle)
        return np.asarray(path_error(poses, targets, rows, self.path.length_scale).max(axis=1))

    def finer(self, s: Array, values: Array) -> tuple[Array, Array, int | None]:
        """A motion through the same configurations, and others between, that stays on the path.

        Args:
            s: Places, (m,).
            values: Joint values there, (m, n).

        Returns:
            Places and joint values; the index of the first step that is no motion along the path, None if all are.
        """
        solver, step, depth = self.solver, np.arange(len(s) - 1), np.zeros(len(s) - 1)
        whole = np.abs(solver.weights * np.diff(values, axis=0)).max(axis=1)
        for _ in range(MOST_HALVINGS):
            todo = np.flatnonzero(self.off(s, values) > self.accuracy) if len(s) > 1 else np.zeros(0, dtype=int)
            if not len(todo):
                return s, values, None
            middle = 0.5 * (s[todo] + s[todo + 1])
            ends, depth[todo] = np.stack([values[todo], values[todo + 1]]), depth[todo] + 1
            most = BENT * SHORTER ** depth[todo] * whole[step[todo]]
            found, wrong = self._halfway(middle, ends, most, lazily=False)
            if wrong.any():
                found[wrong], wrong[wrong] = self._halfway(middle[wrong], ends[:, wrong], most[wrong], lazily=True)
            if wrong.any():
                return s, values, int(step[todo[wrong.argmax()]])
            s, values = np.insert(s, todo + 1, middle), np.insert(values, todo + 1, found, axis=0)
            step, depth = np.insert(step, todo + 1, step[todo]), np.insert(depth, todo + 1, depth[todo])
        wrong = self.off(s, values) > self.accuracy
        return s, values, int(step[wrong.argmax()]) if wrong.any() else None

    def _halfway(self, s: Array, ends: Array, most: Array, *, lazily: bool) -> tuple[Array, NDArray[np.bool_]]:
        """Joint values at places (m,) next to the middle of their ends (2, m, n), and which of them are none."""
        targets = self.path.at(s)
        found, is_one = self.solver.led(targets, ends.mean(axis=0), CLOSE * self.accuracy, lazily=lazily)
        return found, ~is_one | (np.abs(self.solver.weights * (found - ends)).max(axis=(0, 2)) > most)
