"""Chooses the pairs to keep apart: by an SRDF, all that could meet, or those that are given."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.limits.collision_bodies import Bodies, link_solids
from robust_ik.control.limits.collision_scene import CollisionScene, Pair
from robust_ik.control.limits.obstacles import Obstacle
from robust_ik.control.limits.srdf import Srdf
from robust_ik.errors import InputError, UrdfError, suggest
from robust_ik.robot.robot import Robot

SAMPLES = 100
"""An obstacle counts as always near a link if it is near in this many random configurations."""


@dataclass(frozen=True)
class IgnoredPair:
    """A pair that is not kept apart.

    Attributes:
        names: Two links, or a link and an obstacle.
        reason: Why not.
    """

    names: Pair
    reason: str


def possible_scene(
    robot: Robot, obstacles: Sequence[Obstacle], srdf: Srdf | None, least: float
) -> tuple[CollisionScene, list[Pair], list[IgnoredPair]]:
    """All pairs that could meet, and those that are left out; for `least` see `_close_pairs`.

    Raises:
        UrdfError: The SRDF is for another robot.
        LoadError: A mesh cannot be read.
    """
    bodies = Bodies.of(robot)
    pairs, ignored = _possible_pairs(robot, bodies, obstacles, srdf)
    scene = _scene(robot, bodies, obstacles, pairs)
    ignored += sorted(_close_pairs(robot, scene, least), key=lambda each: pairs.index(each.names))
    without = {each.names for each in ignored}
    pairs = [pair for pair in pairs if pair not in without]
    return CollisionScene.of(bodies, scene.of_links, obstacles, pairs), pairs, ignored


def told_scene(
    robot: Robot, obstacles: Sequence[Obstacle], pairs: Iterable[Sequence[str]]
) -> tuple[CollisionScene, list[Pair]]:
    """The pairs that a user names, checked.

    Raises:
        InputError: One is not a pair of links with shapes, or of a link and an obstacle, that a joint moves relative to
            each other; or an obstacle is in no pair.
        LoadError: A mesh cannot be read.
    """
    bodies = Bodies.of(robot)
    checked = _told_pairs(robot, bodies, {each.name for each in obstacles}, pairs)
    return _scene(robot, bodies, obstacles, checked), checked


def _scene(robot: Robot, bodies: Bodies, obstacles: Sequence[Obstacle], pairs: Sequence[Pair]) -> CollisionScene:
    links = {name for pair in pairs for name in pair}
    return CollisionScene.of(bodies, tuple(link_solids(robot, bodies, links)), obstacles, pairs)


def _possible_pairs(
    robot: Robot, bodies: Bodies, obstacles: Iterable[Obstacle], srdf: Srdf | None
) -> tuple[list[Pair], list[IgnoredPair]]:
    """Pairs with shapes that joints move relative to each other, and those of them that are left out by name."""
    links = list(dict.fromkeys(solid.link for solid in robot.description.solids))
    disabled = _disabled(robot, srdf)
    pairs: list[Pair] = []
    ignored: list[IgnoredPair] = []
    for pair in combinations(links, 2):
        first, second = (bodies.of_link[link] for link in pair)
        if first == second:
            continue
        reason = disabled.get(frozenset(pair), "")
        # An SRDF is more exact than the rule that links with one joint between cannot meet.
        if not reason and (_joined(robot, pair) if disabled else _adjacent(bodies, first, second)):
            reason = "adjacent"
        if reason:
            ignored.append(IgnoredPair(pair, reason))
        else:
            pairs.append(pair)
    return pairs + [(link, each.name) for each in obstacles for link in links if bodies.of_link[link] != 0], ignored


def _disabled(robot: Robot, srdf: Srdf | None) -> Mapping[frozenset[str], str]:
    """Pairs that an SRDF disables, with reasons; an SRDF that disables none says nothing about collisions."""
    if srdf is None or not srdf.disabled:
        return {}
    links = set(robot.description.links)
    if not any(pair <= links for pair in srdf.disabled):
        raise UrdfError(f"{srdf.path} is for {srdf.name!r}: it names no two links of {robot.name}")
    return {pair: f"disabled in {srdf.path.name}: {why}" for pair, why in srdf.disabled.items()}


def _adjacent(bodies: Bodies, first: int, second: int) -> bool:
    return bodies.above.get(first) == second or bodies.above.get(second) == first


def _joined(robot: Robot, pair: Pair) -> bool:
    return any({joint.parent, joint.child} == set(pair) for joint in robot.description.joints)


def _told_pairs(robot: Robot, bodies: Bodies, standing: set[str], pairs: object) -> list[Pair]:
    links = {solid.link for solid in robot.description.solids}
    if not isinstance(pairs, Iterable) or getattr(pairs, "ndim", 1) == 0:
        raise InputError(f"pairs must be pairs of names, got {pairs!r}")
    checked = [_told_pair(pair, links, standing) for pair in pairs]
    for a, b in checked:
        if bodies.of_link[a] == bodies.of_link.get(b, 0):
            raise InputError(f"no joint of {robot.name} moves {a!r} relative to {b!r}")
    if unused := standing - {b for _, b in checked}:
        raise InputError(f"obstacle {min(unused)!r} is in none of the pairs")
    return list(dict.fromkeys(checked))


def _told_pair(pair: object, links: set[str], standing: set[str]) -> Pair:
    if not isinstance(pair, (tuple, list)) or len(pair) != 2 or not all(isinstance(name, str) for name in pair):
        raise InputError(f"pairs must be pairs of names, got {pair!r}")
    a, b = pair if pair[0] in links else pair[::-1]
    for name, known in ((a, links), (b, links | standing)):
        if name not in known:
            raise InputError(f"no link with a shape is called {name!r}; {suggest(name, known)}")
    return a, b


def _close_pairs(robot: Robot, scene: CollisionScene, least: float) -> Iterator[IgnoredPair]:
    """Pairs of links nearer than `least` at rest, and of a link and an obstacle always nearer than that."""
    near = _nearest(scene, robot, robot.rest, least)
    always = {pair for pair in near if pair[1] not in scene.bodies.of_link}
    for pair in near.keys() - always:
        yield IgnoredPair(pair, f"{_apart(near[pair])} at rest")
    for q in robot.random(np.random.default_rng(0), SAMPLES if always else 0):
        always &= _nearest(scene, robot, q, least).keys()
    for pair in always:
        yield IgnoredPair(pair, f"{_apart(near[pair])} at rest and never over {least:g} m")


def _nearest(scene: CollisionScene, robot: Robot, q: Array, least: float) -> dict[Pair, float]:
    """The distances of all pairs that are nearer than `least`."""
    nearest: dict[Pair, float] = {}
    for index, there in scene.contacts(robot, q, within=least):
        pair = scene.names(index)
        nearest[pair] = min(there.distance, nearest.get(pair, np.inf))
    return nearest


def _apart(distance: float) -> str:
    return f"{distance:.3g} m apart" if distance >= 0 else f"{-distance:.3g} m inside each other"
