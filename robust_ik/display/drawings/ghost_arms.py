"""Ghosts: where the arm would be at other configurations, as a tube through the origins of its moving links."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.display.drawings.marks import draw_path
from robust_ik.display.scene.meshcat_module import Visualizer
from robust_ik.display.scene.primitives import Color
from robust_ik.robot.robot import Robot

THICKNESS = 0.018
"""Radius of a ghost, as a fraction of half the robot's diagonal. Chosen: thinner than the links of usual arms."""


@dataclass(frozen=True, eq=False)
class GhostArms:
    """Ghosts of a robot with a tip, below one node.

    Attributes:
        visualizer: The node.
        robot: The robot.
        size: Half the diagonal of the robot, m.
        color: The colour of all ghosts.
    """

    visualizer: Visualizer
    robot: Robot
    size: float
    color: Color

    @property
    def frames(self) -> tuple[str, ...]:
        """The links that joints on the way to the tip move, from the base on, and the tip."""
        tip = str(self.robot.tip)
        links = [joint.child for joint in self.robot.description.chain(tip) if joint.kind != "fixed"]
        return tuple(dict.fromkeys([self.robot.description.root, *links, tip]))

    def points(self, q: Array) -> Array:
        """The origins of these frames at a configuration (nq,), those that coincide once, (P, 3), m."""
        every = np.array([self.robot.pose(q, frame)[:3, 3] for frame in self.frames])
        apart = np.linalg.norm(np.diff(every, axis=0), axis=1) > THICKNESS * self.size / 4
        return np.asarray(every[np.concatenate([[True], apart])])

    def draw(self, configurations: Array) -> None:
        """Draws a ghost for each configuration, (g, nq), in place of those that were there."""
        self.visualizer.delete()
        for number, q in enumerate(configurations):
            draw_path(self.visualizer[str(number)], self.points(q), THICKNESS * self.size, self.color)
