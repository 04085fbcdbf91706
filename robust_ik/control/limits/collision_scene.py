"""The solids of a robot and its obstacles, and the closest points of pairs of them at q."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.limits.collision_bodies import Bodies, Solid
from robust_ik.control.limits.collision_geometry import Contact, contact, placed, primitive
from robust_ik.control.limits.obstacles import Obstacle
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.robot.robot import Robot

Pair = tuple[str, str]
FARTHEST = 1e9
"""Farthest position, m: bodies that a sliding joint carries further count as here."""


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

    def contacts(self, robot: Robot, q: Array, within: float = np.inf) -> list[tuple[int, Contact]]:
        """The contact of every pair of solids that is nearer than `within`, with its index, at q (nq,)."""
        poses = self._poses(robot, q)
        near = np.flatnonzero(self._least_distances(poses) < within)
        used = {int(index) for index in (*self.first[near], *self.second[near])}
        ready = {i: placed(poses[self.solids[i].body] @ self.solids[i].placement) for i in used}
        found = []
        for pair in near.tolist():
            i, j = int(self.first[pair]), int(self.second[pair])
            there = contact(self.solids[i].geometry, ready[i], self.solids[j].geometry, ready[j])
            if there.distance < within:
                found.append((pair, there))
        return found

    def rows(self, robot: Robot, q: Array, contacts: Sequence[tuple[int, Contact]]) -> Array:
        """The derivative of the distance of each contact, (r, n), in m per rad or m."""
        rows = np.zeros((len(contacts), robot.n))
        if not contacts:
            return rows
        pairs = [pair for pair, _ in contacts]
        points = np.array([there.point_a + there.point_b for _, there in contacts]) / 2
        normals = np.array([there.normal for _, there in contacts])
        # n · (v + ω × p) = n · v + (p × n) · ω, the same for all points along n.
        wrenches = np.hstack([normals, _cross(points, normals)])
        body_a, body_b = (self._spheres[0][side[pairs]] for side in (self.first, self.second))
        for body in {*body_a.tolist(), *body_b.tolist()} - {0}:
            J = robot.jacobian(q, self.bodies.frames[body], "world", rows=ROWS)
            rows += ((body_b == body) * 1.0 - (body_a == body))[:, None] * (wrenches @ J)
        return rows

    def carried(
        self, robot: Robot, there: Array, here: Array, contacts: Sequence[tuple[int, Contact]]
    ) -> list[tuple[int, Contact]]:
        """Contacts found at one configuration with their points carried along by their bodies to another.

        Args:
            robot: The robot.
            there: Where they were found, (nq,).
            here: Where they are wanted, (nq,).
            contacts: The contacts.

        Returns:
            The same points at `here`, with the normals as they were, and the distances along these.
        """
        before, after = self._poses(robot, there), self._poses(robot, here)
        found = []
        for pair, each in contacts:
            points = []
            for side, point in ((self.first, each.point_a), (self.second, each.point_b)):
                body = self.solids[int(side[pair])].body
                local = before[body][:3, :3].T @ (point - before[body][:3, 3])
                points.append(after[body][:3, :3] @ local + after[body][:3, 3])
            distance = float(each.normal @ (points[1] - points[0]))
            found.append((pair, Contact(distance, each.normal, *points)))
        return found

    def names(self, pair: int) -> Pair:
        """The two links, or link and obstacle, of a pair of solids."""
        return self.solids[self.first[pair]].owner, self.solids[self.second[pair]].owner

    def _poses(self, robot: Robot, q: Array) -> Array:
        """The poses of the watched bodies, (bodies, 4, 4); of the others, the identity."""
        poses = np.tile(np.eye(4), (len(self.bodies.frames), 1, 1))
        for body in self.moving:
            poses[body] = robot.pose(q, self.bodies.frames[body])
        bounded: Array = np.clip(np.nan_to_num(poses), -FARTHEST, FARTHEST)
        return bounded

    def _least_distances(self, poses: Array) -> Array:
        """Lower bounds on the distances of all pairs, (P,), from the bounding spheres."""
        body, center, radius = self._spheres
        at = np.einsum("sij,sj->si", poses[body], center)[:, :3]
        apart: Array = np.linalg.norm(at[self.second] - at[self.first], axis=1) - radius[self.first]
        flat, plane = self._half_spaces
        apart[~flat] -= radius[self.second][~flat]
        apart[flat] = np.einsum("pi,pi->p", at[self.first][flat], plane[:, :3]) - plane[:, 3] - radius[self.first][flat]
        return apart

    @cached_property
    def moving(self) -> list[int]:
        """The bodies with watched solids that joints move."""
        watched = {self.solids[index].body for index in (*self.first, *self.second)}
        return sorted(watched - {0})

    @cached_property
    def _spheres(self) -> tuple[NDArray[np.int_], Array, Array]:
        """For each solid its body, and in that body's frame its sphere's centre, (S, 4), and radius, (S,)."""
        bodies = np.array([solid.body for solid in self.solids], dtype=int)
        centers = [solid.placement @ [*solid.geometry.center, 1.0] for solid in self.solids]
        radii = np.array([solid.geometry.radius for solid in self.solids])
        return bodies, np.array(centers).reshape(-1, 4), radii

    @cached_property
    def _half_spaces(self) -> tuple[NDArray[np.bool_], Array]:
        """Which pairs include a half space, (P,), and normal and offset of those in the world, (H, 4)."""
        seconds = [self.solids[index] for index in self.second]
        flat = np.array([solid.geometry.plane is not None for solid in seconds], dtype=bool)
        planes = []
        for solid in seconds:
            if solid.geometry.plane is not None:
                normal = solid.placement[:3, :3] @ solid.geometry.plane[:3]
                planes.append([*normal, solid.geometry.plane[3] + normal @ solid.placement[:3, 3]])
        return flat, np.array(planes).reshape(-1, 4)


def _cross(a: Array, b: Array) -> Array:
    """The cross products of rows, (N, 3); several times faster than NumPy's."""
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]
