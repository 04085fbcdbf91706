"""Named points of an arm: where neighbouring joint axes meet, in every configuration. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array

SAME = 1e-6
"""Axes that differ by less, m or rad, meet, are parallel or are equal."""


@dataclass(frozen=True, eq=False)
class Axes:
    """The joint axes of an arm at one configuration.

    Attributes:
        directions: Unit vectors, world axes, (n, 3).
        points: A point of each, (n, 3), m.
        turning: Which are axes of rotation, (n,); a prismatic joint has a direction but no line.
    """

    directions: Array
    points: Array
    turning: Array

    @classmethod
    def of(cls, J: Array, tool: Array) -> Axes:
        """The axes from a Jacobian of all six rows, world axes, (6, n), and the tool's point, (3,)."""
        linear, angular = J[:3].T, J[3:].T
        turning = np.linalg.norm(angular, axis=1) > SAME
        directions = np.where(turning[:, None], angular, linear)
        lengths = np.linalg.norm(directions, axis=1, keepdims=True)
        directions = directions / np.where(lengths > 0, lengths, 1.0)
        return cls(directions, tool + np.cross(directions, linear), turning)

    def meeting(self, i: int, j: int) -> Array | None:
        """The point where two axes meet, (3,); None if they are parallel, skew, or not lines."""
        if not (self.turning[i] and self.turning[j]):
            return None
        across = np.cross(self.directions[i], self.directions[j])
        sine = float(np.linalg.norm(across))
        between = self.points[j] - self.points[i]
        if sine < SAME or abs(between @ across) / sine > SAME:
            return None
        along = np.linalg.det([between, self.directions[j], across]) / sine**2
        return np.asarray(self.points[i] + along * self.directions[i])


@dataclass(frozen=True)
class Landmark:
    """A point where neighbouring axes meet.

    Attributes:
        joints: The joints, from 1, neighbours of each other.
    """

    joints: tuple[int, ...]

    def __str__(self) -> str:
        numbers = [str(joint) for joint in self.joints]
        return f"the point where axes {', '.join(numbers[:-1])} and {numbers[-1]} meet"

    def at(self, axes: Axes) -> Array:
        """Its position, (3,)."""
        point = axes.meeting(self.joints[0] - 1, self.joints[1] - 1)
        return np.full(3, np.nan) if point is None else point


def landmarks(axes: Axes) -> tuple[Landmark, ...]:
    """The landmarks of an arm, from any configuration: neighbouring axes keep their distance and their angle."""
    runs: list[list[int]] = []
    last: Array | None = None
    for i in range(len(axes.directions) - 1):
        point = axes.meeting(i, i + 1)
        if point is None:
            last = None
            continue
        if last is not None and np.linalg.norm(point - last) < SAME:
            runs[-1].append(i + 2)
        else:
            runs.append([i + 1, i + 2])
        last = point
    return tuple(Landmark(tuple(run)) for run in runs)
