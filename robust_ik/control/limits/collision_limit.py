"""Limits joint velocities so that links keep their distance from each other and from obstacles."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import compress
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_parameter, readonly
from robust_ik.checks.public_arguments import checked, checked_but
from robust_ik.control.bounds import Bounds
from robust_ik.control.limits.base import Limit
from robust_ik.control.limits.collision_geometry import Contact
from robust_ik.control.limits.collision_pairs import IgnoredPair, possible_scene, told_scene
from robust_ik.control.limits.collision_scene import CollisionScene, Pair
from robust_ik.control.limits.obstacles import Obstacle
from robust_ik.control.limits.placed_pairs import PlacedPairs
from robust_ik.control.limits.srdf import find_srdf, read_srdf
from robust_ik.errors import InputError
from robust_ik.robot.robot import Robot

OURS = " distance"
"""Ending of the causes of these rows."""
LEAST_ROW = 1e-6
"""m per rad: a distance that joints change by less than this does not depend on them."""
NEARER = 1e-7
"""Distances that fall by less than this, m, do not fall, for rounding."""
OVER = 1.25
"""What is asked for more where a step bends, as a multiple of what it came too near."""
ALIKE = 0.1
"""Rows that differ by less than this part are about the same points: within a step they turn by far less."""
RECOVERY_JOINT_SPEED = 0.5
"""On the way out of a collision no joint need be faster than this, rad/s or m/s, or than half its speed limit."""


@dataclass(frozen=True, eq=False)
class PairDistance:
    """The distance of two links, or of a link and an obstacle.

    Attributes:
        names: Two links, or a link and an obstacle.
        distance: m; if they overlap it is negative: how far one must be shifted to be free.
        point_a: The point of the first that is nearest to the second, or deepest inside it, (3,), m, in the world.
        point_b: The same of the second.
    """

    names: Pair
    distance: float
    point_a: Array
    point_b: Array

    def __post_init__(self) -> None:
        for name in ("point_a", "point_b"):
            object.__setattr__(self, name, readonly(getattr(self, name)))


@dataclass(frozen=True, eq=False)
class CollisionLimit(Limit):
    """Keeps links from each other and from obstacles. `CollisionLimit.of(robot, obstacles=...)` makes it.

    A velocity damper for every two convex solids that are nearer than `influence`:

        ḋ ≥ −gain (d − distance),  gain ≤ 1/dt;   and ḋ ≥ recovery_speed is enough inside `distance`,

    so that, to first order, no step uses up more than the distance left, and pairs that are too near separate at a
    bounded speed and never come nearer. Here ḋ = nᵀ (J_b − J_a) q̇ at the nearest points a and b, n from a to b.

    What bends within a step, and nearest points that jump, are of second order. So `tightened` looks where a step ends:
    if a pair would be nearer than `distance` and nearer than before, a controller asks for more speed apart, also of
    the points that would be nearest then, and at last for less speed in all. Only where stronger limits forbid that
    too does a pair come nearer; the resolution then names it among its contradictions.

    Shapes are the robot's collision shapes, or its visuals if it has no collision shapes at all. Meshes are replaced by
    their convex hulls, so that hollow ones, an open gripper for example, are full. If a nearest point jumps (parallel
    faces), the row jumps, but not the distance.

    Source: Faverjon & Tournassoud 1987 (velocity damper): ḋ ≥ −ξ (d − d_s)/(d_i − d_s), with gain = ξ/(d_i − d_s).

    Attributes:
        pairs: Pairs that are kept apart.
        ignored: Pairs that are not kept apart, and why. Links that no joint moves relative to one another are in
            neither.
        distance: The least distance, m.
        influence: The distance below which pairs act, m.
        gain: Largest rate at which the distance left may be used up, 1/s.
        recovery_speed: Speed at which pairs that are too near must separate, m/s.
        joint_names: The joints of its robot.
    """

    pairs: tuple[Pair, ...]
    ignored: tuple[IgnoredPair, ...]
    distance: float
    influence: float
    gain: float
    recovery_speed: float
    joint_names: tuple[str, ...]
    _scene: CollisionScene
    _reach: Array

    @classmethod
    @checked_but("obstacles", "pairs")
    def of(
        cls,
        robot: Robot,
        *,
        obstacles: Iterable[Obstacle] = (),
        srdf: str | Path | None = None,
        pairs: Iterable[Sequence[str]] | None = None,
        distance: float = 0.02,
        influence: float = 0.1,
        gain: float = 10.0,
        recovery_speed: float = 0.1,
    ) -> Self:
        """A limit for all pairs that could meet, or for given ones.

        Left out are pairs that an SRDF disables; without an SRDF, links with a single joint between them or between
        links rigidly attached to them; links that are nearer than `distance` when the robot is at rest; and pairs of a
        link and an obstacle that are always nearer than that, such as the base and its table. See `ignored`.

        Args:
            robot: The robot.
            obstacles: Obstacles around it.
            srdf: An SRDF file; default the one beside the robot's URDF, see `find_srdf`.
            pairs: Pairs of links, or of a link and an obstacle, to keep apart, and no others.
            distance: The least distance, m.
            influence: The distance below which pairs act, m.
            gain: Largest rate at which the distance left may be used up, 1/s; at most 1/dt has effect.
            recovery_speed: Speed at which pairs that are too near must separate, m/s.

        Raises:
            InputError: A parameter or an obstacle is not valid, or a pair does not exist.
            LoadError: The SRDF or a mesh cannot be read.
            UrdfError: The SRDF is broken or for another robot.
        """
        distance = checked_parameter("distance", distance, least=0)
        influence = checked_parameter("influence", influence, above=distance)
        gain = checked_parameter("gain", gain, above=0)
        recovery_speed = checked_parameter("recovery_speed", recovery_speed, above=0)
        standing = _checked_obstacles(robot, obstacles)
        if pairs is not None:
            scene, chosen = told_scene(robot, standing, pairs)
            ignored: list[IgnoredPair] = []
        else:
            disabled = find_srdf(robot) if srdf is None else read_srdf(srdf)
            scene, chosen, ignored = possible_scene(robot, standing, disabled, distance)
        return cls(
            pairs=tuple(chosen),
            ignored=tuple(ignored),
            distance=distance,
            influence=influence,
            gain=gain,
            recovery_speed=recovery_speed,
            joint_names=robot.joint_names,
            _scene=scene,
            _reach=readonly(np.minimum(robot.velocity_limit / 2, RECOVERY_JOINT_SPEED)),
        )

    def bounds(self, robot: Robot, q: Array, previous: Array, dt: float) -> Bounds:  # noqa: ARG002
        """A row for each pair of solids that is nearer than `influence`; see `Limit.bounds`."""
        self._check(robot)
        here = self._scene.at(robot, q)
        return self._bounds(here, here.contacts(self.influence), dt)

    def _bounds(self, here: PlacedPairs, contacts: Sequence[tuple[int, Contact]], dt: float) -> Bounds:
        rows = here.rows(contacts)
        if not contacts:
            return Bounds.of_rows(rows, np.zeros(0), ())
        floor, acting = self._dampers(contacts, rows, dt)
        causes = tuple(self._causes[pair] for pair, _ in compress(contacts, acting))
        if not all(acting):
            rows, floor = rows[acting], floor[acting]
        return Bounds.of_rows(rows, floor, causes)

    def _dampers(self, contacts: Sequence[tuple[int, Contact]], rows: Array, dt: float) -> tuple[Array, list[bool]]:
        """The floors of the rows of contacts, (r,), and which of them act.

        A distance that no joint can change must not contradict others.
        """
        spare = np.array([there.distance for _, there in contacts]) - self.distance
        fastest = np.minimum(self.recovery_speed, np.abs(rows) @ self._reach)
        squares = np.einsum("ij,ij->i", rows, rows)
        acting = [LEAST_ROW**2 < each < np.inf for each in squares.tolist()]
        return np.minimum(fastest, -min(self.gain, 1 / dt) * spare), acting

    def tightened(self, robot: Robot, q: Array, qdot: Array, dt: float, bounds: Bounds) -> Bounds | None:
        """What is asked for more of pairs whose distance the step would bring below `distance`, and below what it was.

        Where the nearest points stay those that a row is about, its floor is raised. Where they jump, as from one
        corner of a box to another, a row for the new ones is added: the old one could not hold them. Their damper is
        added also where the step breaks nothing but that; else a body would rock from corner to corner.
        """
        here = self._scene.at(robot, q)
        near = self._nearness(here, qdot, dt, bounds)
        if near is None:
            return None
        before = dict(here.contacts(self.influence))
        end = q + dt * qdot if robot.nq == robot.n else robot.integrate(q, dt * qdot)
        there, given = self._scene.at(robot, end), bounds
        after = there.contacts(min(self.distance + near, self.influence))
        if not after:
            return None
        carried = there.carried(here, after)
        rows = here.rows(carried)
        floors, acting = self._dampers(carried, rows, dt)
        for (index, ending), row, floor, acts in zip(after, rows, floors.tolist(), acting):
            missing = min(before[index].distance if index in before else np.inf, self.distance) - ending.distance
            more = OVER * missing / dt if missing > NEARER else 0.0
            bounds = self._asked(bounds, self._causes[index], row, floor if acts else None, more, qdot, dt)
        return None if bounds is given else bounds

    def _asked(
        self, bounds: Bounds, cause: str, row: Array, floor: float | None, more: float, qdot: Array, dt: float
    ) -> Bounds:
        """The bounds, with what is asked for more of points where a step ends.

        Args:
            bounds: The bounds.
            cause: The cause of the pair's rows.
            row: How the distance of the points changes, (n,).
            floor: Its damper's floor, m/s; None if joints do not change it.
            more: How much faster the points should part than in the step, m/s; 0 if that does not bring them too near.
            qdot: The step, (n,).
            dt: Its length, s.
        """
        place = self._row_of(bounds, cause, row)
        if place is not None and not more:
            return bounds
        if place is not None:
            raised = bounds.floor.copy()
            raised[place] = max(raised[place], bounds.rows[place] @ qdot + more)
            return replace(bounds, floor=raised)
        if floor is None:
            return bounds
        rate = float(row @ qdot)
        damped = floor > rate + NEARER / dt
        if not (damped or more):
            return bounds
        return replace(
            bounds,
            rows=np.concatenate([bounds.rows, row[None]]),
            floor=np.append(bounds.floor, floor if damped else rate + more),
            row_cause=(*bounds.row_cause, cause),
        )

    def _row_of(self, bounds: Bounds, cause: str, row: Array) -> int | None:
        """Which of the rows of a pair is about the points whose distance has this derivative, if one is."""
        ours = [place for place, name in enumerate(bounds.row_cause) if name == cause]
        if not ours:
            return None
        apart = bounds.rows[ours] - row
        squares = (apart * apart).sum(axis=1)
        nearest = int(np.argmin(squares))
        return ours[nearest] if squares[nearest] <= ALIKE**2 * (row @ row) else None

    def spare(self, robot: Robot, q: Array, within: float) -> dict[int, float]:
        """Distances of pairs of solids minus `distance`; see `Limit.spare`."""
        self._check(robot)
        contacts = self._scene.at(robot, q).contacts(self.distance + within)
        return {index: there.distance - self.distance for index, there in contacts}

    def _nearness(self, here: PlacedPairs, qdot: Array, dt: float, bounds: Bounds) -> float | None:
        """How far a step moves any point at most, m, if something is so near that this could make it too near."""
        ours = [place for place, cause in enumerate(bounds.row_cause) if cause.endswith(OURS)]
        if not ours:
            return None
        floor = bounds.floor if len(ours) == len(bounds.floor) else bounds.floor[ours]
        spare = -float(floor.max()) / min(self.gain, 1 / dt)  # what is too near has a floor ≥ 0
        turned = dt * float(np.abs(qdot).sum())
        if spare >= turned * here.widest:
            return None
        return turned * here.span if spare < turned * here.span else None

    @cached_property
    def _causes(self) -> list[str]:
        """The cause of the rows of each pair of solids."""
        return [" - ".join(names) + OURS for names in self._scene.all_names]

    @checked
    def distances(self, robot: Robot, q: ArrayLike) -> list[PairDistance]:
        """The distances of all pairs, however large, nearest first.

        Args:
            robot: The robot.
            q: Configuration, (nq,).
        """
        self._check(robot)
        q = as_array(q, "q", (robot.nq,))
        if q.ndim != 1:
            raise InputError(f"q must be one configuration of shape ({robot.nq},), got {q.shape}")
        nearest: dict[Pair, Contact] = {}
        for index, there in self._scene.at(robot, q).contacts():
            names = self._scene.names(index)
            if names not in nearest or there.distance < nearest[names].distance:
                nearest[names] = there
        found = [PairDistance(names, each.distance, each.point_a, each.point_b) for names, each in nearest.items()]
        return sorted(found, key=lambda each: each.distance)

    def _check(self, robot: Robot) -> None:
        if self.joint_names != robot.joint_names:
            ours, theirs = ", ".join(self.joint_names), ", ".join(robot.joint_names)
            raise InputError(f"these limits are for {ours}, {robot.name} has {theirs}")


def _checked_obstacles(robot: Robot, obstacles: Iterable[Obstacle]) -> tuple[Obstacle, ...]:
    single = not isinstance(obstacles, Iterable) or getattr(obstacles, "ndim", 1) == 0
    standing: tuple[Any, ...] = (obstacles,) if single else tuple(obstacles)
    taken = set(robot.description.links)
    for each in standing:
        if not isinstance(each, Obstacle):
            raise InputError(f"obstacles must be Obstacle(name, shape, placement), got {each!r}")
        if each.name in taken:
            raise InputError(f"two obstacles, or an obstacle and a link of {robot.name}, are called {each.name!r}")
        taken.add(each.name)
    return standing
