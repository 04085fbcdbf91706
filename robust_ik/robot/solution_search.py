"""Searches for solutions in joint values, from many starts."""

from __future__ import annotations

from dataclasses import dataclass

from robust_ik.checks import Array
from robust_ik.pose_ik import PoseSolver
from robust_ik.robot.joint_map import JointMap

MOST_SEARCHED = 16
"""Most solutions that a search from many starts compares."""


@dataclass(frozen=True, eq=False)
class ManyStarts:
    """A search for solutions of poses from many starts, in joint values.

    Attributes:
        solver: The solver of poses.
        joints: Which joints there are.
    """

    solver: PoseSolver
    joints: JointMap

    def __call__(self, target: Array, near: Array) -> Array:
        """Joint values (s, n) of the solutions that were found of a pose (4, 4), beginning near joint values (n,)."""
        start = self.joints.configuration(near)
        found = self.solver.solve(target, start, solutions=MOST_SEARCHED, effort="thorough")
        return self.joints.values(found.solutions if found.solved else found.solutions[:0])

    def closest(self, target: Array, near: Array) -> Array:
        """Joint values (n,) within limits that come closest to a pose (4, 4), as far as a thorough search finds."""
        return self.joints.values(self.solver.solve(target, self.joints.configuration(near), effort="thorough").q)
