"""Pairs of solids at one configuration: coal is asked only for those that can be near, and once for each."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.limits.collision_bodies import Bodies, Solid
from robust_ik.control.limits.collision_geometry import Contact, Transform, near_contact, placed
from robust_ik.control.limits.pair_motion import PairMotion
from robust_ik.robot.robot import Robot

FARTHEST = 1e9
"""Farthest position, m: bodies that a sliding joint carries further count as here."""
FAR_OUT = 1e6
"""Entries of q beyond this may place bodies further than FARTHEST."""
FEW = 8
"""So many pairs are asked for without a look at their bounding spheres.

Chosen: a look at the spheres of all pairs takes as long as coal takes for about this many.
"""
SOON, AHEAD = 10.0, 0.1
"""Where a look at the spheres is needed, pairs are asked for that may be near after so many motions like the last one,
if all these are shorter than AHEAD, m. Chosen: their distances hold for many steps, the spheres' for few."""
KEPT = 3
"""Configurations that are remembered: where a step begins, where it ends, and another end that was tried."""


class SolidPairs:
    """Pairs of solids, wherever they are.

    Attributes:
        bodies: The bodies of the robot.
        solids: The solids.
        first: The index of the first solid of each pair, (P,), never a half space.
        second: The index of the second one, (P,).
        members: The same, as pairs of plain numbers.
        body: The body of each solid, (S,).
    """

    def __init__(
        self, bodies: Bodies, solids: Sequence[Solid], first: NDArray[np.int_], second: NDArray[np.int_]
    ) -> None:
        self.bodies, self.solids, self.first, self.second = bodies, solids, first, second
        self.members = list(zip(first.tolist(), second.tolist()))
        self.body = np.array([solid.body for solid in solids], dtype=int)

    def __reduce__(self) -> tuple[object, ...]:
        return SolidPairs, (self.bodies, self.solids, self.first, self.second)

    def least_distances(self, poses: Array) -> Array:
        """Lower bounds on the distances of all pairs, (P,), from bounding spheres, by the poses of bodies."""
        center, radius = self._spheres
        at = np.einsum("sij,sj->si", poses[self.body], center)[:, :3]
        apart: Array = np.linalg.norm(at[self.second] - at[self.first], axis=1) - radius[self.first]
        flat, plane = self._half_spaces
        apart[~flat] -= radius[self.second][~flat]
        apart[flat] = np.einsum("pi,pi->p", at[self.first][flat], plane[:, :3]) - plane[:, 3] - radius[self.first][flat]
        return apart

    @cached_property
    def moving(self) -> NDArray[np.int_]:
        """The bodies with watched solids that joints move."""
        watched = {self.solids[index].body for index in (*self.first, *self.second)}
        return np.array(sorted(watched - {0}), dtype=int)

    @cached_property
    def _spheres(self) -> tuple[Array, Array]:
        """For each solid its sphere in the frame of its body: its centre, (S, 4), and radius, (S,)."""
        centers = [solid.placement @ [*solid.geometry.center, 1.0] for solid in self.solids]
        radii = np.array([solid.geometry.radius for solid in self.solids])
        return np.array(centers).reshape(-1, 4), radii

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


class PlacedPairs:
    """Pairs of solids at one configuration.

    Attributes:
        q: The configuration, (nq,).
        slid: How far joints have slid out; see `PairMotion.slid`.
        least: What distances are at least, (P,), m: their own where coal has been asked.
        found: The contacts that have been asked for.
    """

    def __init__(
        self, pairs: SolidPairs, motion: PairMotion, robot: Robot, q: Array, before: PlacedPairs | None = None
    ) -> None:
        """Pairs at a configuration.

        Args:
            pairs: The pairs.
            motion: How the robot moves them.
            robot: The robot.
            q: The configuration, (nq,).
            before: The same pairs at another configuration: from there, distances have changed by so much at most.
        """
        self.q, self.slid = q.copy(), motion.slid(robot, q)
        self._pairs, self._motion, self._robot = pairs, motion, robot
        self.found: dict[int, Contact] = {}
        self._told = robot.pinocchio_q(q)
        self._far_out = not np.abs(q).max() <= FAR_OUT  # written so that NaN is
        self._last: Array | None = None
        self._near_before = {} if before is None else before.found
        if before is None:
            self.least = pairs.least_distances(self.poses)
        else:
            change = q - before.q if robot.nq == robot.n else robot.difference(before.q, q)
            self._last = motion.most(change, max(self.slid, before.slid))
            self.least = before.least - self._last

    @cached_property
    def poses(self) -> Array:
        """The poses of the bodies, (bodies, 4, 4)."""
        poses = self._motion.solids_at(self._told).frames()[self._motion.frames]
        if self._far_out:
            poses = np.clip(np.nan_to_num(poses), -FARTHEST, FARTHEST)
        return poses

    @cached_property
    def _twists(self) -> Array:
        """The twists of the joints, (6, N)."""
        return self._motion.solids_at(self._told).twists()

    @property
    def widest(self) -> float:
        """What `span` is at most, m, without a look at where bodies are."""
        return np.inf if self._motion.slides.size else self._motion.widest

    @cached_property
    def span(self) -> float:
        """The largest distance of the frames of watched bodies from each other and from the world's, m."""
        at = self.poses[[0, *self._pairs.moving.tolist()], :3, 3]
        return float(np.linalg.norm(at[:, None] - at, axis=2).max())

    def contacts(self, within: float = np.inf) -> list[tuple[int, Contact]]:
        """The contact of every pair that is nearer than `within`, with its index."""
        least, found = self.least, self.found
        asked = self._open(within)
        if len(asked) > FEW and sum(pair not in self._near_before for pair in asked) > FEW:
            np.fmax(least, self._pairs.least_distances(self.poses), out=least)
            ahead = np.zeros(1) if self._last is None else SOON * self._last
            asked = self._open(within + np.where(ahead < AHEAD, ahead, 0.0))
        solids, members, motion, q = self._pairs.solids, self._pairs.members, self._motion, self._told
        for pair in asked:
            i, j = members[pair]
            place = self._clipped if self._far_out else motion.transform
            there = near_contact(solids[i].geometry, place(q, i), solids[j].geometry, place(q, j), within)
            if isinstance(there, float):
                least[pair] = there
            else:
                least[pair], found[pair] = there.distance, there
        return [(pair, found[pair]) for pair in sorted(found) if found[pair].distance < within]

    def _clipped(self, _q: Array, solid: int) -> Transform:
        """The pose of a solid, for coal, where bodies may be too far away."""
        there = self._pairs.solids[solid]
        return placed(self.poses[there.body] @ there.placement)

    def _open(self, within: Array | float) -> list[int]:
        """Pairs that may be nearer than that, and that coal has not been asked for yet."""
        (may,), found = (~(self.least >= within)).nonzero(), self.found
        return [pair for pair in may.tolist() if pair not in found]

    def rows(self, contacts: Sequence[tuple[int, Contact]]) -> Array:
        """The derivative of the distance of each contact, (r, n), in m per rad or m."""
        if not contacts:
            return np.zeros((0, self._robot.n))
        pairs = [pair for pair, _ in contacts]
        points = 0.5 * _stacked([there.point_a + there.point_b for _, there in contacts])
        normals = _stacked([there.normal for _, there in contacts])
        # n · (v + ω × p) = n · v + (p × n) · ω, the same for all points along n.
        wrenches = np.concatenate([normals, _cross(points, normals)], axis=1)
        way = self._motion.way[pairs]
        rows = way * (wrenches @ self._twists)
        if not math.isfinite(rows.sum()):  # joints far away: not those that move none of the two
            rows[way == 0] = 0.0
        return rows if self._motion.followers is None else rows @ self._motion.followers

    def carried(self, elsewhere: PlacedPairs, contacts: Sequence[tuple[int, Contact]]) -> list[tuple[int, Contact]]:
        """Contacts found here with their points carried along by their bodies to another configuration.

        Args:
            elsewhere: The same pairs where the contacts are wanted.
            contacts: The contacts.

        Returns:
            The same points there, with the normals as they were, and the distances along these.
        """
        pairs, found = [pair for pair, _ in contacts], [there for _, there in contacts]
        points_a = self._moved(elsewhere, self._pairs.first[pairs], [there.point_a for there in found])
        points_b = self._moved(elsewhere, self._pairs.second[pairs], [there.point_b for there in found])
        return [
            (pair, Contact(float(there.normal @ (b - a)), there.normal, a, b))
            for pair, there, a, b in zip(pairs, found, points_a, points_b)
        ]

    def _moved(self, elsewhere: PlacedPairs, solids: NDArray[np.int_], points: list[Array]) -> Array:
        """Points of solids carried along by their bodies, (N, 3)."""
        body = self._pairs.body[solids]
        before, after = self.poses[body], elsewhere.poses[body]
        local = (_stacked(points) - before[:, :3, 3])[:, None] @ before[:, :3, :3]
        return np.asarray((local @ after[:, :3, :3].transpose(0, 2, 1))[:, 0] + after[:, :3, 3])


class RecentPlaces(threading.local):
    """Where pairs have been last, for each thread."""

    def __init__(self) -> None:
        self._robot: Robot | None = None
        self._motion: PairMotion | None = None
        self._places: list[tuple[bytes, PlacedPairs]] = []

    def __reduce__(self) -> tuple[object, ...]:
        # Without what is remembered, which costs time but changes no result.
        return RecentPlaces, ()

    def at(self, pairs: SolidPairs, robot: Robot, q: Array) -> PlacedPairs:
        """The pairs at q, (nq,): those of before if they have been there, else new ones."""
        if robot is not self._robot or self._motion is None:
            self._places, self._robot = [], robot
            self._motion = PairMotion.of(robot, pairs.bodies, pairs.solids, pairs.first, pairs.second)
        key = q.tobytes()
        for index, (known, place) in enumerate(self._places):
            if key == known:
                if index:
                    self._places.insert(0, self._places.pop(index))
                return place
        if not math.isfinite(q.sum()):
            robot.joint_values(q)  # raises, unless the sum alone is too large
        before = self._places[0][1] if self._places else None
        made = PlacedPairs(pairs, self._motion, robot, q, before)
        self._places = [(key, made), *self._places[: KEPT - 1]]
        return made


def _stacked(vectors: list[Array]) -> Array:
    """Vectors (3,) as rows, (N, 3): several times faster than an array of a list."""
    return np.concatenate(vectors).reshape(-1, 3)


def _cross(a: Array, b: Array) -> Array:
    """The cross products of rows, (N, 3); several times faster than NumPy's."""
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]
