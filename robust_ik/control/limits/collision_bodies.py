"""The rigid bodies of a robot and the convex solids on them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.limits.collision_geometry import Geometry, convex_hull, primitive
from robust_ik.description.joint_tree import FREEDOM, Description, Mesh, Visual
from robust_ik.errors import LoadError
from robust_ik.robot.robot import Robot


@dataclass(frozen=True)
class Bodies:
    """The rigid bodies of a robot: links that no joint moves relative to one another.

    Attributes:
        frames: The first link of each body, from the root on; the root's body does not move.
        of_link: The index of the body of each link.
        above: The index of the body that carries each body except the first; what moves in a plane is carried by it.
    """

    frames: tuple[str, ...]
    of_link: Mapping[str, int]
    above: Mapping[int, int]

    @classmethod
    def of(cls, robot: Robot) -> Self:
        """The bodies for the joints of `robot.model`; other joints of the description are fixed."""
        description, moving = robot.description, set(robot.model.names)
        first = {link: description.rigid_body(link, moving) for link in description.links}
        frames = tuple(dict.fromkeys([description.root, *(first[link] for link in description.links)]))
        of_link = {link: frames.index(frame) for link, frame in first.items()}
        # What moves in a plane stands on what has the plane, though there are links without shapes between them.
        planes = [parts for parts in description.parts.values() if len(parts) < FREEDOM]
        below = {parts[-1]: description.joint[parts[0]].parent for parts in planes}
        joints = [joint for joint in description.joints if joint.child in frames]
        above = {of_link[joint.child]: of_link[below.get(joint.name, joint.parent)] for joint in joints}
        return cls(frames, of_link, above)


class Solid(NamedTuple):
    """A convex solid on a body.

    Attributes:
        owner: Its link or obstacle.
        body: The index of the body that carries it.
        placement: Its pose in the frame of that body, (4, 4).
        geometry: The solid.
    """

    owner: str
    body: int
    placement: Array
    geometry: Geometry


def link_solids(robot: Robot, bodies: Bodies, links: set[str]) -> Iterator[Solid]:
    """The solids of some links; meshes are replaced by their convex hulls.

    Raises:
        LoadError: A mesh cannot be read.
    """
    read: dict[Mesh, Geometry] = {}
    for visual in robot.description.solids:
        if visual.link in links:
            body = bodies.of_link[visual.link]
            frame = robot.pose(robot.rest, bodies.frames[body])
            placement = np.linalg.solve(frame, robot.pose(robot.rest, visual.link)) @ visual.placement
            yield Solid(visual.link, body, placement, _geometry(visual, robot.description, read))


def _geometry(visual: Visual, description: Description, read: dict[Mesh, Geometry]) -> Geometry:
    from robust_ik.description.meshes import UnreadableMeshError, read_vertices

    if not isinstance(visual.shape, Mesh):
        return primitive(visual.shape)
    if visual.shape not in read:
        try:
            read[visual.shape] = convex_hull(read_vertices(visual.shape))
        except (UnreadableMeshError, RuntimeError) as error:
            raise LoadError(
                f"{description.source}: the distances of link {visual.link!r} need its mesh {visual.shape.name!r}, "
                f"which {error}; mend it, or name pairs= without that link"
            ) from error
    return read[visual.shape]
