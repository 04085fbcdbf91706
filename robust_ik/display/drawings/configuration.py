"""Draws one configuration of a robot, with its lost directions and its manipulability."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import alone, as_array
from robust_ik.checks.public_arguments import checked
from robust_ik.display.drawings.drawn_robot import DrawnRobot, MissingMesh, draw_robot
from robust_ik.display.drawings.following_marks import FollowingMarks
from robust_ik.display.drawings.marks import GAMMA
from robust_ik.display.scene.scene import Scene
from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class DrawnConfiguration:
    """A robot in a scene with its marks, which go where it goes.

    Attributes:
        drawn: The robot in the scene.
        marks: Its marks; None for a robot without a tip.
        size: Half the diagonal of the robot where it was drawn first, m.
    """

    drawn: DrawnRobot
    marks: FollowingMarks | None
    size: float

    @property
    def missing_meshes(self) -> tuple[MissingMesh, ...]:
        """Meshes that are replaced by stand-ins."""
        return self.drawn.missing_meshes

    def show(self, q: ArrayLike) -> None:
        """Moves the robot and its marks to a configuration, (nq,); no shape is sent again."""
        q = alone(as_array(q, "q", (self.drawn.robot.nq,)), "q", 1)
        self.drawn.show(q)
        if self.marks is not None:
            self.marks.show(q)


@checked
def draw_configuration(
    scene: Scene, robot: Robot, q: ArrayLike | None = None, *, gamma: float = GAMMA
) -> DrawnConfiguration:
    """Draws a robot with its lost directions and its manipulability ellipsoid, in place of what was there.

    Args:
        scene: The scene.
        robot: The robot; without a tip only its shape is drawn.
        q: Configuration, (nq,); default `robot.rest`.
        gamma: A direction counts as being lost below this fraction of the largest singular value.

    Returns:
        The drawing; its `show(q)` moves the robot and its marks.
    """
    q = robot.rest if q is None else q
    scene.clear()
    drawn = draw_robot(scene["robot"], robot, q)
    extent = drawn.extent(q)
    size = float(np.linalg.norm(extent[1] - extent[0])) / 2
    scene.look_at(extent)
    scene.add_floor(1.5 * size, min(0.0, float(extent[0, 2])))
    marks = None if robot.tip is None else FollowingMarks.draw(scene, robot, gamma, size)
    if marks is not None:
        marks.show(np.asarray(q, dtype=float))
    return DrawnConfiguration(drawn, marks, size)
