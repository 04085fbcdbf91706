"""A UR5's tool on a straight line through a singularity, and the angle between its motion and the motion asked for.

Speed limits can be met by slowing the whole motion, or by letting some joints lag; lagging joints turn the tool's
motion although nothing forces it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array
from robust_ik.control.resolution import Resolution
from robust_ik.control.resolvers import Resolver
from robust_ik.control.tasks import Follow, Line
from robust_ik.control.velocity_controller import VelocityController
from robust_ik.kinematics.svd import svd
from robust_ik.robot.loading import load
from robust_ik.robot.robot import Robot

GAIN, DT = 5.0, 0.01
"""Gain, 1/s, and step, s, as of `Stretch`. Chosen: a loop is stable for GAIN · DT below 2, and this is 0.05."""


@dataclass(frozen=True, eq=False)
class Asked:
    """One step: configuration, twist asked for, and resolution.

    Attributes:
        q: Configuration, (nq,).
        J: Its Jacobian, (6, n).
        twist: Twist asked for, (6,).
        resolution: The result of the resolver.
    """

    q: Array
    J: Array
    twist: Array
    resolution: Resolution


@dataclass(frozen=True, eq=False)
class StraightLine:
    """The motion; `steps(resolver)` runs it.

    Attributes:
        robot: The robot.
        q0: Start configuration, (nq,).
        path: The line.
        gamma: Directions with σ ≤ γσ₁ count as being lost; use the same γ for the robust inverse.
    """

    robot: Robot
    q0: Array
    path: Line
    gamma: float

    def steps(self, resolver: Resolver) -> Iterator[Asked]:
        """Every step of a run with one resolver, within the robot's own limits."""
        controller = VelocityController(self.robot, resolver, calm=False)
        motion, q = Follow(self.path, gain=GAIN, feedforward=True), self.q0
        for i in range(round(self.path.duration / DT)):
            stack = motion(i * DT)
            equation = stack[0][0].equation(self.robot, q)
            resolution = controller.step(q, stack, DT)
            yield Asked(q, equation.J, equation.xdot, resolution)
            q = self.robot.integrate(q, DT * resolution.qdot)


def ur5_elbow() -> StraightLine:
    """From a bent elbow straight away from the shoulder at 0.5 m/s, through the full stretch and beyond reach."""
    robot = load("ur5")
    q0 = np.array([0.3, -1.0, 1.2, -1.2, 1.2, 0.0])
    start = robot.pose(q0)
    shoulder = robot.pose(q0, "shoulder_link")[:3, 3]
    outwards = start[:3, 3] - shoulder
    goal = start[:3, 3] + 0.5 * outwards / np.linalg.norm(outwards)
    return StraightLine(robot, q0, Line(start, goal, 0.5), gamma=0.02)


def ur5_wrist() -> StraightLine:
    """Half a metre at 0.5 m/s with the wrist stretching out on the way: q5 passes zero."""
    robot = load("ur5")
    q0 = np.array([-0.26, -1.06, 1.81, -0.75, -0.26, 0.01])
    start = robot.pose(q0)
    direction = np.array([0.45, 0.52, 0.72])
    goal = start[:3, 3] + 0.5 * direction / np.linalg.norm(direction)
    return StraightLine(robot, q0, Line(start, goal, 0.5), gamma=0.02)


def turned(J: ArrayLike, twist: ArrayLike, qdot: ArrayLike, gamma: float) -> float:
    """The angle between the twist asked for and J q̇, in the directions that are not being lost, rad.

    Args:
        J: (6, n).
        twist: Twist asked for, (6,).
        qdot: Joint velocities, (n,).
        gamma: Directions with σ ≤ γσ₁ are left out.
    """
    J = as_array(J, "J", (None, None))
    decomposition = svd(J)
    kept = decomposition.U[:, decomposition.s > gamma * decomposition.s[0]]
    asked = kept.T @ as_array(twist, "twist", (len(J),))
    given = kept.T @ (J @ as_array(qdot, "qdot", (J.shape[1],)))
    lengths = np.linalg.norm(asked), np.linalg.norm(given)
    if min(lengths) < 1e-12:
        return 0.0
    asked, given = asked / lengths[0], given / lengths[1]
    # Accurate for small angles too, unlike the arc cosine.
    return float(2 * np.arctan2(np.linalg.norm(asked - given), np.linalg.norm(asked + given)))
