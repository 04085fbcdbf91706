"""The solids of a robot and its obstacles, and the pairs of them to watch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.limits.collision_bodies import Bodies, Solid
from robust_ik.control.limits.collision_geometry import Contact, primitive
from robust_ik.control.limits.obstacles import Obstacle
from robust_ik.control.limits.placed_pairs import PlacedPairs, RecentPlaces, SolidPairs
from robust_ik.robot.robot import Robot

Pair = tuple[str, str]


@dataclass(frozen=True, eq=False)
class CollisionScene:
    """Solids, and the pairs of them to watch.

    Attributes:
        bodies: The bodies of the robot.
        solids: Solids of the robot's links, then of obstacles.
        first: The index of the first solid of each pair, (P,), never a half space.
        second: The index of the second one, (P,).
    """

    bodies: Bodies
    solids: tuple[Solid, ...]
    first: NDArray[np.int_]
    second: NDArray[np.int_]
    _recent: RecentPlaces = field(default_factory=RecentPlaces, repr=False)

    @classmethod
    def of(cls, bodies: Bodies, solids: Sequence[Solid], obstacles: Sequence[Obstacle], pairs: Sequence[Pair]) -> Self:
        """A scene with all pairs of solids that belong to the two names of a given pair."""
        standing = (Solid(each.name, 0, each.placement, primitive(each.shape)) for each in obstacles)
        everything = (*solids, *standing)
        owned: dict[str, list[int]] = {}
        for index, solid in enumerate(everything):
            owned.setdefault(solid.owner, []).append(index)
        indices = [(i, j) for a, b in pairs for i in owned[a] for j in owned[b]]
        first, second = np.array(indices, dtype=int).reshape(-1, 2).T
        return cls(bodies, everything, first, second)

    @property
    def of_links(self) -> tuple[Solid, ...]:
        """The solids of the robot."""
        return tuple(solid for solid in self.solids if solid.owner in self.bodies.of_link)

    def at(self, robot: Robot, q: Array) -> PlacedPairs:
        """The pairs at a configuration, (nq,); what is known of them there, or near there, is known already."""
        return self._recent.at(self._pairs, robot, q)

    def contacts(self, robot: Robot, q: Array, within: float = np.inf) -> list[tuple[int, Contact]]:
        """The contact of every pair of solids that is nearer than `within`, with its index, at q (nq,)."""
        return self.at(robot, q).contacts(within)

    def rows(self, robot: Robot, q: Array, contacts: Sequence[tuple[int, Contact]]) -> Array:
        """The derivative of the distance of each contact, (r, n), in m per rad or m."""
        return self.at(robot, q).rows(contacts)

    def names(self, pair: int) -> Pair:
        """The two links, or link and obstacle, of a pair of solids."""
        return self.solids[self.first[pair]].owner, self.solids[self.second[pair]].owner

    @cached_property
    def all_names(self) -> list[Pair]:
        """The names of all pairs of solids."""
        return [self.names(pair) for pair in range(len(self.first))]

    @cached_property
    def _pairs(self) -> SolidPairs:
        return SolidPairs(self.bodies, self.solids, self.first, self.second)
