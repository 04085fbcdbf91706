"""Marks that follow a robot from configuration to configuration: lost directions and the manipulability ellipsoid."""

from __future__ import annotations

from dataclasses import dataclass

from robust_ik.checks import Array
from robust_ik.display.drawings import marks
from robust_ik.display.drawings.marks import Ellipsoids, LostDirections
from robust_ik.display.scene.animation_tracks import Still
from robust_ik.display.scene.scene import Scene
from robust_ik.robot.robot import Robot

MARK = 0.35
"""Largest half-length of a mark, as a fraction of half the robot's diagonal. Chosen: seen beside it, not over it."""
THINNEST = 0.005
"""Thickness of a flat ellipsoid, as such a fraction. Chosen: still seen from its edge."""


@dataclass(frozen=True, eq=False)
class FollowingMarks:
    """Marks at the tip of a robot; their shapes are sent once, and moved with `show`.

    Attributes:
        scene: The scene.
        robot: The robot, which has a tip.
        gamma: A direction counts as being lost below this fraction of the largest singular value.
        size: Half the diagonal of the robot, m.
    """

    scene: Scene
    robot: Robot
    gamma: float
    size: float

    @classmethod
    def draw(cls, scene: Scene, robot: Robot, gamma: float, size: float) -> FollowingMarks:
        """Draws the marks of a robot, hidden until `show` is called."""
        marks.draw_lost(scene["lost"], len(robot.rows))
        marks.draw_ellipsoid(scene["ellipsoid"])
        scene["ellipsoid"].set_property("visible", False)
        return cls(scene, robot, gamma, size)

    def show(self, q: Array) -> None:
        """Moves the marks to where the robot is at a configuration, (nq,)."""
        J, tip = self.robot.jacobian(q)[None], self.robot.pose(q)[None, :3, 3]
        still = Still()
        lost = LostDirections.of(J, self.robot.rows, self.gamma)
        marks.animate_lost(still, self.scene["lost"], len(self.robot.rows), lost, tip, MARK * self.size)
        ellipsoids = Ellipsoids.of(J, self.robot.rows)
        longest = 0.0 if ellipsoids is None else float(ellipsoids.lengths.max())
        self.scene["ellipsoid"].set_property("visible", longest > 0)
        if ellipsoids is not None and longest > 0:
            scale = MARK * self.size / longest
            marks.animate_ellipsoid(still, self.scene["ellipsoid"], ellipsoids, tip, scale, THINNEST * self.size)
        still.place()
