"""Robot description as plain values: joints as a tree, and shapes of links. No Pinocchio."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from robust_ik.checks import Array
from robust_ik.errors import FrameNotFoundError, suggest

MOVING_TYPES = ("revolute", "continuous", "prismatic")
FREEDOM = 6
"""How many joints a floating joint is taken as: one for each way in which a body moves."""


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: position = multiplier · source + offset."""

    source: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Joint:
    """One joint of the tree; limits that are not stated are infinite.

    Attributes:
        name: Joint name.
        kind: "revolute", "continuous", "prismatic", "fixed", "floating" or "planar".
        parent: Link that carries it.
        child: Link that it moves.
        lower: Lower position limit, rad or m.
        upper: Upper position limit, rad or m.
        velocity: Speed limit, rad/s or m/s.
        mimic: The joint that it follows, or None for an independent joint.
        problem: Why it cannot move as written in the file; empty if it can.
        length: Distance of its origin from its parent's, m.
        part_of: The planar or floating joint of the file that it is a part of; empty for any other.
    """

    name: str
    kind: str
    parent: str
    child: str
    lower: float
    upper: float
    velocity: float
    mimic: Mimic | None = None
    problem: str = ""
    length: float = 0.0
    part_of: str = ""


@dataclass(frozen=True)
class Box:
    """A box, side lengths in metres."""

    size: tuple[float, float, float]


@dataclass(frozen=True)
class Sphere:
    """A sphere, radius in metres."""

    radius: float


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z, in metres."""

    radius: float
    length: float


@dataclass(frozen=True)
class Mesh:
    """A mesh file.

    Attributes:
        name: The path as the description writes it.
        path: The file, or None when it was not found.
        scale: Factors along x, y, z.
        root: The folder from which the mesh and the files it refers to may be read.
        problem: Why there is no path; empty otherwise.
    """

    name: str
    path: Path | None
    scale: tuple[float, float, float]
    root: Path | None
    problem: str = ""


Shape = Box | Sphere | Cylinder | Mesh


@dataclass(frozen=True, eq=False)
class Visual:
    """A shape fixed to a link.

    Attributes:
        link: The link that carries it.
        placement: Pose in the link frame, (4, 4).
        shape: The geometry.
        color: RGBA in [0, 1], or None for the mesh's own; collision shapes have none.
    """

    link: str
    placement: Array
    shape: Shape
    color: tuple[float, float, float, float] | None = None


@dataclass(frozen=True, eq=False)
class Description:
    """A checked robot description.

    Attributes:
        name: The robot's name.
        xml: URDF text that Pinocchio builds from.
        links: Link names, in file order.
        joints: Joints, in file order.
        visuals: Shapes to draw.
        source: Its file or other origin, for messages.
        notes: What the user should know about the reading of the file, one sentence each.
        collisions: Collision shapes of the file, if any.
        file: The file it was read from, absolute, or None for text.
    """

    name: str
    xml: str
    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    visuals: tuple[Visual, ...]
    source: str
    notes: tuple[str, ...] = ()
    collisions: tuple[Visual, ...] = ()
    file: Path | None = None

    @property
    def solids(self) -> tuple[Visual, ...]:
        """Shapes for collision checks: the collision shapes, or the visuals if the description has none at all."""
        return self.collisions or self.visuals

    @cached_property
    def joint(self) -> dict[str, Joint]:
        """Joints by name."""
        return {joint.name: joint for joint in self.joints}

    @cached_property
    def _links(self) -> frozenset[str]:
        return frozenset(self.links)

    @cached_property
    def _joint_above(self) -> dict[str, Joint]:
        return {joint.child: joint for joint in self.joints}

    @cached_property
    def root(self) -> str:
        """The link without a parent joint."""
        return next(link for link in self.links if link not in self._joint_above)

    @cached_property
    def leaves(self) -> tuple[str, ...]:
        """Links without child joints."""
        parents = {joint.parent for joint in self.joints}
        return tuple(link for link in self.links if link not in parents)

    def link_of(self, frame: str) -> str:
        """The link of a frame name: the link itself, or the child link of the joint of that name."""
        if frame in self._links:
            return frame
        if frame in self.joint:
            return self.joint[frame].child
        raise FrameNotFoundError(
            f"{self.name} has no link or joint {frame!r}; {self.taken_as(frame)}"
            f"{suggest(str(frame), [*self.links, *self.joint])}"
        )

    def taken_as(self, name: object) -> str:
        """What a planar or floating joint of the file is taken as, for a message; empty for any other name."""
        parts = self.parts.get(name) if isinstance(name, str) else None
        return f"in the file it moves in {len(parts)} ways and is taken as {', '.join(parts)}; " if parts else ""

    def chain(self, frame: str) -> tuple[Joint, ...]:
        """The joints from the root to a frame, fixed ones included."""

        def upwards(link: str) -> Iterator[Joint]:
            while link in self._joint_above:
                joint = self._joint_above[link]
                yield joint
                link = joint.parent

        return tuple(reversed(list(upwards(self.link_of(frame)))))

    def rigid_body(self, link: str, moving: Collection[str]) -> str:
        """The first link of the rigid body to which a link belongs if only the joints in `moving` move."""
        while link in self._joint_above and self._joint_above[link].name not in moving:
            link = self._joint_above[link].parent
        return link

    def moving_joints(self, frame: str) -> tuple[str, ...]:
        """The independent joints that move a frame, from the root on; a mimic joint is replaced by its source."""
        names = [self.driver[joint.name].source for joint in self.chain(frame) if joint.kind != "fixed"]
        return tuple(dict.fromkeys(names))

    @cached_property
    def parts(self) -> dict[str, tuple[str, ...]]:
        """For each planar or floating joint of the file, the joints that it is taken as."""
        wholes = dict.fromkeys(joint.part_of for joint in self.joints if joint.part_of)
        return {whole: tuple(joint.name for joint in self.joints if joint.part_of == whole) for whole in wholes}

    def floating(self, frame: str) -> tuple[str, ...]:
        """The six joints that the first floating joint above a frame is taken as; empty if there is none."""
        above = {joint.name for joint in self.chain(frame)}
        found = (parts for parts in self.parts.values() if len(parts) == FREEDOM and above.issuperset(parts))
        return next(found, ())

    @cached_property
    def driver(self) -> dict[str, Mimic]:
        """For each joint, the independent joint that drives it, through any chain of mimics, or itself."""
        drivers: dict[str, Mimic] = {}
        for joint in self.joints:
            waiting = []
            while joint.name not in drivers and joint.mimic is not None:
                waiting.append(joint)
                joint = self.joint[joint.mimic.source]
            drivers.setdefault(joint.name, Mimic(joint.name, 1.0, 0.0))
            for follower in reversed(waiting):
                mimic = follower.mimic
                assert mimic is not None
                base = drivers[mimic.source]
                drivers[follower.name] = Mimic(
                    base.source, mimic.multiplier * base.multiplier, mimic.multiplier * base.offset + mimic.offset
                )
        return drivers
