"""Draws a robot in a MeshCat scene: a node for each link, with its shapes below."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, alone, as_array
from robust_ik.checks.public_arguments import checked
from robust_ik.description.joint_tree import Box, Cylinder, Mesh, Sphere
from robust_ik.description.meshes import Color, Part, UnreadableMeshError, read_mesh
from robust_ik.display.drawings.stand_in_shapes import BONE, KNUCKLE, Skeleton
from robust_ik.display.scene.animation_tracks import Tracks
from robust_ik.display.scene.meshcat_module import Visualizer, geometry
from robust_ik.display.scene.node_names import node_names
from robust_ik.display.scene.primitives import GREY, material, triangle_mesh
from robust_ik.robot.robot import Robot

Y_TO_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotates shapes that three.js builds along y to lie along z, like the URDF's cylinders."""


@dataclass(frozen=True)
class MissingMesh:
    """A mesh that is not drawn.

    Attributes:
        link: Its link.
        name: The path as the description writes it.
        reason: Why it is not drawn.
    """

    link: str
    name: str
    reason: str


@dataclass(frozen=True, eq=False)
class DrawnRobot:
    """A robot in a scene.

    Attributes:
        visualizer: The node that holds it.
        robot: The robot.
        nodes: Node name of every link that is drawn.
        missing_meshes: Meshes that are replaced by stand-ins.
        corners: Corners of the box around each link's shapes, in its frame, (8, 3).
    """

    visualizer: Visualizer
    robot: Robot
    nodes: dict[str, str]
    missing_meshes: tuple[MissingMesh, ...]
    corners: dict[str, Array]

    def node(self, link: str) -> Visualizer:
        """The scene node of a link; its transform is the link's pose."""
        return self.visualizer[self.nodes[link]]

    def show(self, q: ArrayLike) -> None:
        """Moves the robot to a configuration, (nq,)."""
        q = alone(as_array(q, "q", (self.robot.nq,)), "q", 1)
        for link in self.nodes:
            self.node(link).set_transform(self.robot.pose(q, link))

    def animate(self, tracks: Tracks, q: Array) -> None:
        """Adds tracks along configurations (N, nq) for links that the joints move; other links keep their poses."""
        moved = set(self.robot.joint_names)
        for link in self.nodes:
            if moved & set(self.robot.description.moving_joints(link)):
                tracks.pose(self.node(link), self.robot.pose(q, link))

    def poses(self, q: Array) -> dict[str, Array]:
        """Poses (N, 4, 4) of the drawn links at configurations (N, nq)."""
        return {link: self.robot.pose(q, link) for link in self.nodes}

    def extent(self, q: ArrayLike) -> Array:
        """Least and greatest world coordinates of the drawn robot at a configuration, (2, 3)."""
        points = [np.zeros((1, 3))]
        for link, corners in self.corners.items():
            T = self.robot.pose(q, link)
            points.append(corners @ T[:3, :3].T + T[:3, 3])
        everything = np.concatenate(points[1:] or points)
        return np.stack([everything.min(axis=0), everything.max(axis=0)])


@checked
def draw_robot(visualizer: Visualizer, robot: Robot, q: ArrayLike | None = None) -> DrawnRobot:
    """Draws a robot in a scene.

    A mesh that is missing or broken is listed in the result and replaced by bones and knuckles, as for a robot without
    any shapes.

    Args:
        visualizer: The node below which it is drawn; earlier drawings there are removed.
        robot: The robot.
        q: Configuration, (nq,); default `robot.rest`.
    """
    q = robot.rest if q is None else alone(as_array(q, "q", (robot.nq,)), "q", 1)
    visualizer.delete()
    pencil = _Pencil(visualizer, robot)
    missing = tuple(pencil.draw_visuals())
    seen = {visual.link for visual in robot.description.visuals} - {lost.link for lost in missing}
    # If shapes are missing, links without shapes are drawn too; otherwise the arm would have gaps.
    whole = bool(missing) or not robot.description.visuals
    bare = set(robot.description.links) - seen if whole else set()
    pencil.draw_stand_ins(link for link in robot.description.links if link in bare)
    nodes = {link: name for link, name in pencil.names.items() if link in pencil.corners}
    corners = {link: _box_corners(np.concatenate(boxes)) for link, boxes in pencil.corners.items()}
    drawn = DrawnRobot(visualizer, robot, nodes, missing, corners)
    drawn.show(q)
    return drawn


class _Pencil:
    """Draws the shapes of one robot, and reads each mesh file once."""

    def __init__(self, visualizer: Visualizer, robot: Robot) -> None:
        self.visualizer, self.robot = visualizer, robot
        self.names = node_names(robot.description.links)
        self.corners: dict[str, list[Array]] = {}
        self._read: dict[Mesh, tuple[Part, ...] | UnreadableMeshError] = {}

    def draw_visuals(self) -> Iterator[MissingMesh]:
        """Draws all visuals; yields those that cannot be drawn."""
        for index, visual in enumerate(self.robot.description.visuals):
            if not isinstance(visual.shape, Mesh):
                shape, half_size, turn = _primitive(visual.shape, visual.color or GREY)
                self._put(visual.link, f"visual{index}", shape, visual.placement @ turn, [-half_size, half_size])
                continue
            parts = self._parts(visual.shape)
            if isinstance(parts, UnreadableMeshError):
                yield MissingMesh(visual.link, visual.shape.name, str(parts))
                continue
            for number, part in enumerate(parts):
                shape = triangle_mesh(part.triangles, visual.color or part.color)
                self._put(visual.link, f"visual{index}_{number}", shape, visual.placement, part.triangles.bounds)

    def draw_stand_ins(self, links: Iterable[str]) -> None:
        """Draws bones and knuckles for links."""
        skeleton = Skeleton.of(self.robot)
        for link in links:
            pieces = {"bones": (skeleton.bones(link), BONE), "knuckle": (skeleton.knuckle(link), KNUCKLE)}
            for name, (triangles, color) in pieces.items():
                if triangles is not None:
                    self._put(link, name, triangle_mesh(triangles, color), np.eye(4), triangles.bounds)

    def _parts(self, mesh: Mesh) -> tuple[Part, ...] | UnreadableMeshError:
        if mesh not in self._read:
            try:
                self._read[mesh] = read_mesh(mesh)
            except UnreadableMeshError as error:
                self._read[mesh] = error
        return self._read[mesh]

    def _put(self, link: str, name: str, shape: Any, placement: Array, bounds: ArrayLike) -> None:
        node = self.visualizer[self.names[link]][name]
        node.set_object(shape)
        node.set_transform(placement)
        corners = _box_corners(np.asarray(bounds, dtype=float))
        self.corners.setdefault(link, []).append(corners @ placement[:3, :3].T + placement[:3, 3])


def _primitive(shape: Box | Sphere | Cylinder, color: Color) -> tuple[Any, Array, Array]:
    """A meshcat object, half its size along its own axes, and the rotation from the URDF's axes to its own."""
    look, turn = material(color), np.eye(4)
    if isinstance(shape, Box):
        return geometry.Mesh(geometry.Box(list(shape.size)), look), np.array(shape.size) / 2, turn
    if isinstance(shape, Sphere):
        return geometry.Mesh(geometry.Sphere(shape.radius), look), np.full(3, shape.radius), turn
    turn[:3, :3] = Y_TO_Z
    half = np.array([shape.radius, shape.length / 2, shape.radius])
    return geometry.Mesh(geometry.Cylinder(shape.length, shape.radius), look), half, turn


def _box_corners(bounds: Array) -> Array:
    """The eight corners of the box that spans the rows of `bounds`."""
    return np.array(list(product(*zip(bounds.min(axis=0), bounds.max(axis=0)))))
