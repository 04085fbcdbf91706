"""How the joints of a robot move pairs of solids relative to each other: which of them do, and how far at most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.limits.collision_bodies import Bodies, Solid
from robust_ik.control.limits.collision_geometry import Transform, placed
from robust_ik.robot.pinocchio_model import PlacedSolids
from robust_ik.robot.robot import Robot

FOR_ROUNDING = 1 + 1e-6
"""Bounds are larger by this factor, so that rounding does not break them."""


@dataclass(eq=False)
class _Place:
    """Where the solids are at present.

    Attributes:
        transforms: The pose of each solid, for coal.
        told: Which of them hold where it is.
        q: Pinocchio's configuration; None before the first.
    """

    transforms: list[Transform]
    told: set[int] = field(default_factory=set)
    q: Array | None = None


@dataclass(frozen=True, eq=False)
class PairMotion:
    """How the N joints of a robot's model move P pairs of solids.

    A solid that a joint turns moves by no more than the angle times its farthest distance from the axis, in any
    configuration of the joints between: at most the lengths of the links between, and what joints have slid out. A
    distance changes by no more than one of its solids moves relative to the other.

    Attributes:
        solids: The solids on the robot's joints.
        frames: For each body, the index of its joint among the frames of `solids`; 0 is the world.
        way: +1 where a joint moves the second solid of a pair alone, −1 where it moves the first alone, else 0, (P, N).
        farthest: Most that the distance of a pair changes per rad or m of a joint, with sliding joints at zero, (P, N).
        extended: Where what joints have slid out is to be added to that, 1, else 0, (P, N).
        slides: Indices of sliding joints in Pinocchio's configuration.
        widest: Most that frames of joints are apart from each other and from the world's, if no joint slides, m.
        followers: Motions of all joints per motion of each independent joint, (N, n); None if they are the same.
    """

    solids: PlacedSolids
    frames: NDArray[np.int_]
    way: Array
    farthest: Array
    extended: Array
    slides: NDArray[np.int_]
    widest: float
    followers: Array | None
    _place: _Place = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_place", _Place([placed(np.eye(4)) for _ in range(self.solids.count)]))

    @classmethod
    def of(
        cls,
        robot: Robot,
        bodies: Bodies,
        solids: Sequence[Solid],
        first: NDArray[np.int_],
        second: NDArray[np.int_],
    ) -> Self:
        """The motion of pairs of solids, by their indices."""
        model, names = robot.model, list(robot.model.names)
        above = {joint.child: joint.name for joint in robot.description.joints}
        frames = np.array([0, *(names.index(above[frame]) for frame in bodies.frames[1:])], dtype=int)
        slides = np.array([name in _sliding(robot) for name in names], dtype=bool)
        moves, reach, extended = np.zeros((3, len(solids), len(names)))
        for index, solid in enumerate(solids):
            center = solid.placement[:3, :3] @ solid.geometry.center + solid.placement[:3, 3]
            joint, length, slid = int(frames[solid.body]), float(np.linalg.norm(center)) + solid.geometry.radius, False
            while joint:
                moves[index, joint] = 1.0
                reach[index, joint] = 1.0 if slides[joint] else length
                extended[index, joint] = slid and not slides[joint]
                slid = slid or bool(slides[joint])
                length += float(np.linalg.norm(model.jointPlacements[joint].translation))
                joint = model.parents[joint]
        way = moves[second] - moves[first]
        alone = [np.where(way > 0, each[second], np.where(way < 0, each[first], 0.0)) for each in (reach, extended)]
        carried = [(int(frames[solid.body]), solid.placement, solid.geometry.solid) for solid in solids]
        return cls(
            solids=PlacedSolids(model, carried),
            frames=frames,
            way=way[:, 1:],
            farthest=FOR_ROUNDING * alone[0][:, 1:],
            extended=FOR_ROUNDING * alone[1][:, 1:],
            slides=np.array([model.idx_qs[joint] for joint in np.flatnonzero(slides).tolist()], dtype=int),
            widest=FOR_ROUNDING * sum(float(np.linalg.norm(each.translation)) for each in model.jointPlacements),
            followers=None if len(names) == robot.n + 1 else robot.mixing,
        )

    def solids_at(self, q: Array) -> PlacedSolids:
        """The solids where they are at Pinocchio's configuration, until the next call; that array must not change."""
        if q is not self._place.q:
            self.solids.place(q)
            self._place.q = q
            self._place.told.clear()
        return self.solids

    def transform(self, q: Array, solid: int) -> Transform:
        """The pose of a solid at Pinocchio's configuration, for coal, until another one is asked for."""
        place = self._place
        if q is not place.q or solid not in place.told:
            place.transforms[solid].setTransform(*self.solids_at(q).placement(solid))
            place.told.add(solid)
        return place.transforms[solid]

    def slid(self, robot: Robot, q: Array) -> float:
        """How far joints that slide between a turning joint and a solid have slid out at most, in all, m."""
        if not self.extended.any():
            return 0.0
        return float(np.abs(robot.pinocchio_q(q)[self.slides]).sum())

    def most(self, change: Array, slid: float) -> Array:
        """Most that distances change, (P,), m, where the independent joints move by `change`, (n,)."""
        moved = np.abs(change)
        if self.followers is not None:
            moved = np.abs(self.followers) @ moved
        most: Array = self.farthest @ moved
        return most + slid * (self.extended @ moved) if slid else most


def _sliding(robot: Robot) -> set[str]:
    return {joint.name for joint in robot.description.joints if joint.kind == "prismatic"}
