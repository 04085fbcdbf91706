"""Solves the poses of places on a path, and what is known of the joints. Arrays only."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robust_ik.branches import BranchSolver
from robust_ik.checks import Array
from robust_ik.inverses import DampedLeastSquares
from robust_ik.kinematics.svd import singular_values
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.paths.path_error import path_error, path_twist
from robust_ik.paths.solution_layers import Layers

LONGEST = 0.35
"""Longest step of a joint between two places, rad: where solutions are further apart places are added between."""
KEEN, LAZY, STEPS = DampedLeastSquares(1e-3), DampedLeastSquares(0.05), 24
"""How a pose is approached that shall be reached, and one that need not be; how many steps are taken at most."""
EXACT = 1e-9
"""How near a pose counts as reached, in length scales and rad."""
LOST = 1e-6
"""Singular values up to this part of the largest one count as zero."""
AT_LIMIT = 1e-9
"""A joint that passes its limit by less is at it, rad or m."""


@dataclass(frozen=True, eq=False)
class LayerSolver:
    """The arm of a path.

    Attributes:
        branches: All solutions of poses.
        closest: Joint values (n,) within limits that come closest to a pose (4, 4), as far as a thorough search from
            joint values (n,) finds.
        values_of: Joint values of configurations, (..., nq) → (..., n).
        length_scale: m per rad.
    """

    branches: BranchSolver
    closest: Callable[[Array, Array], Array]
    values_of: Callable[[Array], Array]
    length_scale: float

    @property
    def lower(self) -> Array:
        """Limits, (n,)."""
        return self.branches.lower

    @property
    def upper(self) -> Array:
        """Limits, (n,)."""
        return self.branches.upper

    @cached_property
    def sliding(self) -> NDArray[np.bool_]:
        """Which of the n joints slide."""
        made, chain = np.zeros(self.branches.chain.n, dtype=bool), self.branches.chain
        made[chain.column[chain.sliding]] = True
        return made

    @cached_property
    def moving(self) -> NDArray[np.bool_]:
        """Which of the n joints move the frame."""
        return np.isin(np.arange(self.branches.chain.n), self.branches.chain.column)

    @cached_property
    def rank(self) -> int:
        """The rank that the Jacobian has nearly everywhere: the largest one at some random joint values."""
        rng = np.random.default_rng(3)
        s = singular_values(self.jacobians(rng.uniform(-2, 2, (20, len(self.lower))) / self.weights))
        return int((s > LOST * s[:, :1]).sum(axis=1).max())

    def margins(self, values: Array) -> Array:
        """The least singular value over the largest one, (..., n) → (...): of as many as the rank; 0 if all are 0."""
        s = singular_values(self.jacobians(values))
        largest = np.where(s[..., 0] > 0, s[..., 0], 1.0)
        return np.asarray(s[..., max(self.rank, 1) - 1] / largest)

    @cached_property
    def weights(self) -> Array:
        """Rad per unit of motion of each joint, (n,)."""
        return np.where(self.sliding, 1.0 / self.length_scale, 1.0)

    @cached_property
    def joints(self) -> Array:
        """The joints' table for the kernel, (4, n)."""
        return np.array([self.sliding.astype(float), self.lower, self.upper, self.weights])

    def difference(self, a: Array, b: Array) -> Array:
        """A − b, turns modulo 2π, (..., n)."""
        d = a - b
        return np.where(self.sliding, d, d - 2 * np.pi * np.round(d / (2 * np.pi)))

    def poses(self, values: Array) -> Array:
        """The frame at joint values, (..., n) → (..., 4, 4)."""
        return self.branches.chain.poses(self.branches.to_q(values))

    def led(
        self, targets: Array, starts: Array, accuracy: float, *, lazily: bool = False
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Joint values next to others that reach poses, or come as close to them as is asked for.

        Args:
            targets: Poses, (m, 4, 4).
            starts: Joint values, (m, n).
            accuracy: How far each may be from its pose, m, and rad times the length scale.
            lazily: Come that close by damped steps, as near singularities where solutions are far.

        Returns:
            Joint values with the turns next to the starts, (m, n), and whether they are that close, within limits, and
            no step of a joint is longer than LONGEST.
        """
        if lazily:
            return self._judged(targets, starts, self._descended(targets, starts, LAZY, accuracy), accuracy)
        values = self._descended(targets, starts, KEEN, EXACT * self.length_scale)
        found, is_close = self._judged(targets, starts, values, accuracy)
        if not is_close.all():
            far = ~is_close
            found[far], is_close[far] = self.led(targets[far], starts[far], accuracy, lazily=True)
        return found, is_close

    def _judged(self, targets: Array, starts: Array, values: Array, accuracy: float) -> tuple[Array, NDArray[np.bool_]]:
        motion = self.difference(values, starts)
        found = starts + motion
        off = path_error(self.poses(found), targets, self.branches.rows, self.length_scale)
        within = ((found >= self.lower - AT_LIMIT) & (found <= self.upper + AT_LIMIT)).all(axis=1)
        near = np.abs(self.weights * motion).max(axis=1) < LONGEST
        return np.clip(found, self.lower, self.upper), (off <= accuracy) & within & near

    def _descended(self, targets: Array, starts: Array, inverse: DampedLeastSquares, accuracy: float) -> Array:
        """Joint values behind damped steps from others, that end where poses are missed by the accuracy."""
        values, rows = np.array(starts), self.branches.rows
        scale = np.array([self.length_scale if row in ROWS[:3] else 1.0 for row in rows])
        for _ in range(STEPS):
            far = path_error(self.poses(values), targets, rows, self.length_scale) > accuracy
            if not far.any():
                break
            twist = path_twist(self.poses(values[far]), targets[far], rows) / scale
            step = inverse.solve(self.jacobians(values[far]), twist) / self.weights
            values[far] = np.clip(values[far] + step, self.lower, self.upper)
        return values

    def jacobians(self, values: Array) -> Array:
        """Jacobians in the rows, (..., n) → (..., m, n): lengths over the length scale."""
        rows = [ROWS.index(row) for row in self.branches.rows]
        J = self.branches.chain.jacobians(self.branches.to_q(values), "local_world_aligned")[..., rows, :]
        return J / np.where(np.array(rows) < 3, self.length_scale, 1.0)[:, None] / self.weights

    def layers(self, s: Array, targets: Array, near: Array) -> Layers:
        """The solutions of poses at places."""
        values, counts, complete = self.branches.joint_solutions(targets, near)
        return Layers(s, targets, np.ascontiguousarray(values), counts, complete)
