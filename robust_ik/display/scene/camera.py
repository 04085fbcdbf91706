"""The camera: far enough to see everything, and looking across the plane in which the arm moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.display.scene.meshcat_module import Visualizer
from robust_ik.kinematics.svd import svd

CAMERA = "/Cameras/default/rotated/<object>"
FIELD_OF_VIEW = 36.0
"""Angle of view from the lower to the upper edge, degrees.

Chosen: meshcat's own 75 makes near links look far too large.
"""
USUAL = np.array([0.37, -0.93, 0.0])
"""Usual direction to the camera in pictures of robots, if nothing else matters."""
_ABOVE = np.array([0.2, -0.52, 0.83]) / np.linalg.norm([0.2, -0.52, 0.83])
"""Direction from which flat scenes are seen, a unit vector. Chosen: the side of USUAL, but steeply from above."""


@dataclass(frozen=True, eq=False)
class View:
    """A ball in view, and the direction to the camera.

    Attributes:
        center: Its centre, (3,), m.
        radius: Its radius, m.
        direction: Unit vector from the centre to the camera, (3,).
    """

    center: Array
    radius: float
    direction: Array

    @classmethod
    def of(cls, points: Array, along: Array | None = None, front: Array | None = None) -> View:
        """A view of points (N, 3), from slightly above; of flat, horizontal sets, from above.

        Args:
            points: Points that must be in view.
            along: Direction that should lie across the view, (3,); default the horizontal one in which the points
                spread most.
            front: Direction that should point towards the camera rather than away from it, (3,).
        """
        low, high = points.min(axis=0), points.max(axis=0)
        center = (low + high) / 2
        radius = max(float(np.linalg.norm(points - center, axis=1).max()), 1e-3)
        spread = points - points.mean(axis=0)
        if along is None or np.hypot(along[0], along[1]) < 0.1 * np.linalg.norm(along):
            along = svd(spread.T @ spread + 1e-12 * np.eye(3)).U @ [1.0, 0.2, 0.0]
        flat = high[2] - low[2] < 0.3 * radius
        return cls(center, radius, _ABOVE if flat else _across(along, USUAL if front is None else front + 0.3 * USUAL))

    def set_on(self, visualizer: Visualizer) -> None:
        """Sends the view to the viewer. Our pages read `view`; meshcat's own reads the position and the angle only."""
        camera = visualizer[CAMERA]
        x, y, z = self.center + 1.1 * self.radius / np.sin(np.radians(FIELD_OF_VIEW / 2)) * self.direction
        camera.set_property("fov", FIELD_OF_VIEW)
        # three.js looks along a scene with y upwards.
        camera.set_property("position", [float(x), float(z), float(-y)])
        camera.set_property("view", [*map(float, self.center), self.radius, *map(float, self.direction)])


def _across(along: Array, front: Array) -> Array:
    """A direction perpendicular to the level part of `along`, on the side of `front`, turned to its end and up."""
    level = np.array([along[0], along[1], 0.0])
    length = float(np.linalg.norm(level))
    level = level / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    side = np.array([level[1], -level[0], 0.0])
    side = side if side @ front >= 0 else -side
    towards = side + 0.5 * level + np.array([0.0, 0.0, 0.42])
    return np.asarray(towards / np.linalg.norm(towards))
