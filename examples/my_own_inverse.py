"""Writes an inverse of its own: a filter says what becomes of 1/σ; then all that takes inverses takes it."""

from dataclasses import dataclass

import numpy as np

import robust_ik as rik


@dataclass(frozen=True)
class Capped(rik.SingularValueFilter):
    """φ(σ) = 1/σ, and never more than 1/floor.

    Attributes:
        floor: The least that a singular value counts as.
    """

    source = "of my own, 2026"
    floor: float = 0.05

    def gains(self, s):
        """φ(σ), (..., k); 0 where σ is 0, so that a lost direction is left alone."""
        s = np.asarray(s, dtype=float)
        return np.where(s > 0, 1.0 / np.maximum(s, self.floor), 0.0)

    def largest_gain(self, sigma_max):
        """Least upper bound of φ."""
        return 1.0 / self.floor

    def is_exact(self, s):
        """Where φ(σ) is 1/σ."""
        return np.asarray(s) >= self.floor


robot, mine = rik.load("ur5"), Capped(floor=0.1)
straight = robot.configuration([0.4, -1.0, 0.0, -0.7, 0.9, 0.0])  # the elbow is singular here
for name, q in (("bent", straight + np.array([0, 0, 0.8, 0, 0, 0])), ("straight", straight)):
    qdot = mine.solve(robot.jacobian(q), [0.1, 0, 0, 0, 0, 0])
    print(f"{name:<10} largest joint speed {np.abs(qdot).max():.2f} rad/s")
path = rik.OutAndBack(robot.pose(straight), goal=[1.1, 0.2, 0.3])
run = rik.simulate(robot, mine, rik.Follow(path, gain=5.0), straight, duration=path.duration)
print(f"out of reach and back: peak {run.largest_speed:.2f} rad/s")
