"""The simulations of Kim, Marani, Chung, Yuh: a planar arm on a circle of which a part is out of reach.

The paper does not say the link lengths, the circle's centre and period, the start and the feedback gain. Those here are
ours (`robots/planar_3r`), so results agree in kind, and the bounds on the measures in digits.

Source: Kim, Marani, Chung, Yuh, section V.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.loading import load
from robust_ik.paths import Circle
from robust_ik.resolvers import Resolver
from robust_ik.robot import Robot
from robust_ik.simulation import simulate
from robust_ik.tasks import Follow, OrientationTask
from robust_ik.trajectory import Trajectory

RADIUS, PERIOD, GAIN, DT = 0.3, 4.0, 50.0, 1e-3
BOUND, ORIENTATION_BOUND = 0.06, 0.3
"""m̄ of the position, from the paper, and of the orientation, ours."""


@dataclass(frozen=True, eq=False)
class KimCircle:
    """The run; `run(resolver)` gives its record.

    Attributes:
        robot: The planar arm, rows x and z.
        q0: At the inner point of the circle, the last link upwards, (3,).
        path: The circle in the x-z plane.
        orientation: Whether the second task holds the last link upwards, at 90°.
    """

    robot: Robot
    q0: Array
    path: Circle
    orientation: bool

    def run(self, resolver: Resolver, progress: Callable[[int, int], None] | None = None) -> Trajectory:
        """One turn of the circle with one resolver; the arm has no limits."""
        upwards = OrientationTask(self.path.start[:3, :3], gain=GAIN, rows=("wy",))
        motion = Follow(self.path, gain=GAIN, feedforward=True, below=[[upwards]] if self.orientation else [])
        return simulate(self.robot, resolver, motion, self.q0, duration=PERIOD, dt=DT, limits=(), progress=progress)


def kim_circle(centre: float = 0.75, *, orientation: bool = False, elbow: int = 1) -> KimCircle:
    """The scenario; .75 m or .70 m from the base the circle leaves the reach of .96 m by .09 m or .04 m.

    Args:
        centre: x of the circle's centre, m.
        orientation: Whether there is a second task.
        elbow: 1 or −1: to which side it is bent at the start.
    """
    robot = load("planar_3r")
    q0 = _upright(centre - RADIUS, elbow)
    start = robot.pose(q0)
    path = Circle(start, np.array([centre, start[1, 3], 0.0]), np.array([0.0, 1.0, 0.0]), PERIOD)
    return KimCircle(robot, q0, path, orientation)


def _upright(x: float, elbow: int) -> Array:
    """Joint angles with the tip at (x, 0) and the last link along z."""
    first, second, last = 0.36, 0.36, 0.24
    z = -last
    bend = elbow * np.arccos((x**2 + z**2 - first**2 - second**2) / (2 * first * second))
    lift = np.arctan2(z, x) - np.arctan2(second * np.sin(bend), first + second * np.cos(bend))
    return np.array([lift, bend, np.pi / 2 - lift - bend])
