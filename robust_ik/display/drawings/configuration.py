"""Draws one configuration of a robot, with its lost directions and its manipulability."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks.public_arguments import checked
from robust_ik.display.drawings import marks
from robust_ik.display.drawings.drawn_robot import DrawnRobot, draw_robot
from robust_ik.display.drawings.marks import GAMMA, Ellipsoids, LostDirections
from robust_ik.display.scene.animation_tracks import Still
from robust_ik.display.scene.scene import Scene
from robust_ik.robot.robot import Robot


@checked
def draw_configuration(scene: Scene, robot: Robot, q: ArrayLike | None = None, *, gamma: float = GAMMA) -> DrawnRobot:
    """Draws a robot with its lost directions and its manipulability ellipsoid, in place of what was there.

    Args:
        scene: The scene.
        robot: The robot; without a tip only its shape is drawn.
        q: Configuration, (nq,); default `robot.rest`.
        gamma: A direction counts as being lost below this fraction of the largest singular value.
    """
    q = robot.rest if q is None else q
    scene.clear()
    drawn = draw_robot(scene["robot"], robot, q)
    extent = drawn.extent(q)
    size = float(np.linalg.norm(extent[1] - extent[0])) / 2
    scene.look_at(extent)
    scene.add_floor(1.5 * size, min(0.0, float(extent[0, 2])))
    if robot.tip is not None:
        _draw_marks(scene, robot, np.asarray(q, dtype=float), gamma, size)
    return drawn


def _draw_marks(scene: Scene, robot: Robot, q: ArrayLike, gamma: float, size: float) -> None:
    J, tip = robot.jacobian(q)[None], robot.pose(q)[None, :3, 3]
    still = Still()
    lost = LostDirections.of(J, robot.rows, gamma)
    marks.draw_lost(scene["lost"], lost.count)
    marks.animate_lost(still, scene["lost"], lost.count, lost, tip, 0.35 * size)
    ellipsoids = Ellipsoids.of(J, robot.rows)
    if ellipsoids is not None and ellipsoids.lengths.max() > 0:
        marks.draw_ellipsoid(scene["ellipsoid"])
        scale = 0.35 * size / float(ellipsoids.lengths.max())
        marks.animate_ellipsoid(still, scene["ellipsoid"], ellipsoids, tip, scale, 0.005 * size)
    still.place()
