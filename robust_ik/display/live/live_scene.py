"""LiveScene: the drawing of a session: the robot, its marks, its target, ghosts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.display.drawings.configuration import DrawnConfiguration, draw_configuration
from robust_ik.display.drawings.ghost_arms import GhostArms
from robust_ik.display.drawings.marks import draw_target
from robust_ik.display.live.live_session import MOST_SHOWN, LiveSession, Nearby
from robust_ik.display.scene.primitives import Color
from robust_ik.display.scene.scene import Scene
from robust_ik.robot.robot import Robot

NEAREST: Color = (0.80, 0.47, 0.65, 0.55)
SOLUTION: Color = (0.90, 0.62, 0.0, 0.45)
TARGET = 0.12
"""Size of the target, as a fraction of half the robot's diagonal. Chosen: large enough to be taken with a finger."""


@dataclass(frozen=True, eq=False)
class LiveScene:
    """What is drawn of a session.

    Attributes:
        scene: The scene.
        drawing: The robot with its marks.
        nearest: The ghost of the nearest singular configuration.
        solutions: Ghosts of all solutions of the pose.
    """

    scene: Scene
    drawing: DrawnConfiguration
    nearest: GhostArms
    solutions: GhostArms

    @classmethod
    def draw(cls, scene: Scene, robot: Robot, q: Array) -> LiveScene:
        """Draws a robot with a tip at a configuration, (nq,)."""
        drawing = draw_configuration(scene, robot, q)
        draw_target(scene["target"], TARGET * drawing.size)
        nearest, solutions = (
            GhostArms(scene["ghosts"][name], robot, drawing.size, color)
            for name, color in (("nearest", NEAREST), ("solutions", SOLUTION))
        )
        return cls(scene, drawing, nearest, solutions)

    def show(self, session: LiveSession, nearby: Nearby | None) -> None:
        """Moves everything to where the session is.

        Args:
            session: The session.
            nearby: The nearest singular configuration; None while it is not known.
        """
        self.drawing.show(session.q)
        self.scene["target"].set_transform(session.kept)
        if nearby is not None:
            self.nearest.draw(nearby.q[None])
        found = session.solutions
        self.solutions.draw(np.empty((0, session.robot.nq)) if found is None else found.q[:MOST_SHOWN])
