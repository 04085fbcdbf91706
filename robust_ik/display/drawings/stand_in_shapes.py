"""Stand-ins for links without shapes: bones between joints, knuckles along their axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.description.meshes import Triangles
from robust_ik.display.scene.primitives import rod
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot

BONE, KNUCKLE = (0.62, 0.66, 0.71, 1.0), (0.27, 0.36, 0.47, 1.0)


@dataclass(frozen=True, eq=False)
class Skeleton:
    """The origins of a robot's links at q = 0.

    Attributes:
        robot: The robot.
        poses: Pose of every link in the world, (4, 4).
        axes: Unit axis in the world of the joint that moves a link, if one does.
        size: Largest distance between two links' origins, m.
    """

    robot: Robot
    poses: dict[str, Array]
    axes: dict[str, Array]
    size: float

    @classmethod
    def of(cls, robot: Robot) -> Skeleton:
        """The skeleton of a robot."""
        poses = {link: robot.pose(robot.neutral, link) for link in robot.description.links}
        points = np.array([T[:3, 3] for T in poses.values()])
        size = float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))
        axes = {}
        for index, name in enumerate(robot.joint_names):
            joint = robot.description.joint[name]
            motion = robot.jacobian(robot.neutral, joint.child, rows=ROWS)[:, index]
            axis = motion[:3] if joint.kind == "prismatic" else motion[3:]
            axes[joint.child] = axis / np.linalg.norm(axis)
        return cls(robot, poses, axes, size if size > 1e-6 else 1.0)

    def bones(self, link: str) -> Triangles | None:
        """Rods in the link's frame, from its origin to the origins of the next links; None if there are none."""
        ends = [self._seen_from(link, joint.child) for joint in self.robot.description.joints if joint.parent == link]
        radius = 0.012 * self.size
        rods = [rod(np.zeros(3), end, radius) for end in ends if np.linalg.norm(end) > 1e-6 * self.size]
        return Triangles.joined(rods) if rods else None

    def knuckle(self, link: str) -> Triangles:
        """A short cylinder along the axis of the joint that moves the link; a cube if none does."""
        radius = 0.022 * self.size
        if link not in self.axes:
            return rod(np.array([0, 0, -radius / 2]), np.array([0, 0, radius / 2]), 0.8 * radius, sides=4)
        axis = self.poses[link][:3, :3].T @ self.axes[link]
        return rod(-1.4 * radius * axis, 1.4 * radius * axis, radius)

    def _seen_from(self, link: str, child: str) -> Array:
        T = self.poses[link]
        return np.asarray(T[:3, :3].T @ (self.poses[child][:3, 3] - T[:3, 3]))
