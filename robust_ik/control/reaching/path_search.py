"""Searches for paths through joint space past forbidden configurations, in small pieces so that each step stays short.

Source: Kuffner & LaValle 2000 (RRT-Connect), with shortcuts; the same random numbers for every search.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.reaching.search_space import LOOK, Space

Pieces = Generator[None, None, Any]
"""A generator that yields after each check of a configuration, the costly part, and then returns the result."""

KEEP = 0.003
"""Extra distance that a path keeps from what is forbidden, m."""
LEAST_MOVE = 0.01
"""Distance, m, that points of the robot may move between two checks even if something is near."""
GROWTH = 0.4
"""Largest growth of a tree at once, rad or m."""
NODES, SHORTCUTS = 1500, 80
"""Most nodes of both trees; number of attempts to shorten a path."""
AROUND = 1.6
"""Distance beyond start and goals, rad or m, within which paths are looked for."""
FULL = 1e-9
"""Missing room, or remaining way, below this counts as zero, m or rad.

Chosen: far above rounding, far below what matters.
"""


class PathSearch:
    """A search from one start to any of several goals.

    A pair that is nearer to a collision at the start or at a goal than a path should be may be half as near there.
    """

    def __init__(self, space: Space, start: Array, goals: Array) -> None:
        self.space, self.start, self.goals = space, start, goals
        self._floors = _halved(space.spare(start))
        self._rng = np.random.default_rng(0)

    def free_goals(self) -> Pieces:
        """Which goals are not forbidden, (g,) of bool."""
        free = []
        for goal in self.goals:
            spare = self.space.spare(goal)
            free.append(min(spare.values(), default=0.0) >= -FULL)
            if free[-1]:
                for name, floor in _halved(spare).items():
                    self._floors[name] = min(floor, self._floors.get(name, KEEP))
            yield
        return np.array(free, dtype=bool)

    def is_free(self, a: Array, b: Array) -> Pieces:
        """Whether the straight way from a to b, without its start, is free."""
        change = b - a
        moved = float(np.abs(change) @ self.space.lever)  # largest motion of any point, m
        s = spare = 0.0
        while s < 1.0:
            s = min(1.0, s + max(LEAST_MOVE, spare) / max(moved, FULL))
            spare = self._spare(a + s * change)
            yield
            if spare < 0:
                return False
        return True

    def _spare(self, x: Array) -> float:
        near = self.space.spare(x)
        return min((far - self._floors.get(name, KEEP) for name, far in near.items()), default=LOOK)

    def connect(self, goals: Array) -> Pieces:
        """Points of a path from the start to one of the goals, (k, n); None if none is found."""
        trees = Tree(self.start[None]), Tree(goals)
        grown, other = trees
        low, high = self._box(goals)
        while len(grown) + len(other) < NODES:
            sample = self.start.copy()
            joints = self.space.joints
            sample[joints] = self._rng.uniform(low[joints], high[joints])
            new = yield from self._grow(grown, sample, once=True)
            if new is not None:
                met = yield from self._grow(other, grown.points[new], once=False)
                if met is not None and np.allclose(other.points[met], grown.points[new], rtol=0, atol=FULL):
                    ends = (new, met) if grown is trees[0] else (met, new)
                    return np.array(trees[0].back(ends[0])[::-1] + trees[1].back(ends[1])[1:])
            grown, other = other, grown
        return None

    def _box(self, goals: Array) -> tuple[Array, Array]:
        ends = np.concatenate([self.start[None], goals])
        return (
            np.maximum(ends.min(axis=0) - AROUND, np.minimum(self.space.lower, self.start)),
            np.minimum(ends.max(axis=0) + AROUND, np.maximum(self.space.upper, self.start)),
        )

    def _grow(self, tree: Tree, towards: Array, *, once: bool) -> Pieces:
        """The last node on the way of a tree towards a point; None if it cannot grow."""
        index, grown = tree.nearest(towards), None
        while True:
            here = tree.points[index]
            apart = float(np.linalg.norm(towards - here))
            if apart <= FULL:
                return index if grown is None else grown
            there = towards if apart <= GROWTH else here + (towards - here) * (GROWTH / apart)
            if not (yield from self.is_free(here, there)):
                return grown
            index = grown = tree.add(there, index)
            if once or apart <= GROWTH:
                return grown

    def shortened(self, points: Array) -> Pieces:
        """A shorter path, by straight ways between two of its points."""
        for _ in range(SHORTCUTS):
            if len(points) < 3:
                break
            lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
            ends = np.concatenate([[0.0], np.cumsum(lengths)])
            a, b = np.sort(self._rng.uniform(0.0, ends[-1], 2))
            i, j = np.searchsorted(ends, a, "right") - 1, np.searchsorted(ends, b, "right") - 1
            if i == j:
                continue
            first, last = (np.array([np.interp(at, ends, column) for column in points.T]) for at in (a, b))
            if (yield from self.is_free(first, last)):
                points = np.concatenate([points[: i + 1], first[None], last[None], points[j + 1 :]])
        return (yield from self._pruned(points))

    def _pruned(self, points: Array) -> Pieces:
        """The path without points that can be left out."""
        kept, index = [points[0]], 0
        while index < len(points) - 1:
            for to in range(len(points) - 1, index, -1):
                if to == index + 1 or (yield from self.is_free(points[index], points[to])):
                    break
            index = to
            kept.append(points[index])
        return np.array(kept)


class Tree:
    """A tree of points, each with the index of its parent; the first ones are roots."""

    def __init__(self, roots: Array) -> None:
        self.points = list(roots)
        self._from = [-1] * len(roots)

    def __len__(self) -> int:
        return len(self.points)

    def nearest(self, x: Array) -> int:
        """The index of the nearest point."""
        return int(np.argmin(((np.array(self.points) - x) ** 2).sum(axis=1)))

    def add(self, x: Array, before: int) -> int:
        """Adds a point after its parent; returns its index."""
        self.points.append(x)
        self._from.append(before)
        return len(self.points) - 1

    def back(self, index: int) -> list[Array]:
        """The points from one back to its root."""
        way = []
        while index >= 0:
            way.append(self.points[index])
            index = self._from[index]
        return way


def _halved(spare: dict[Any, float]) -> dict[Any, float]:
    """Floors for distances below `KEEP`: half of each, or the distance itself if it is already negative."""
    return {name: far / 2 if far > 0 else far for name, far in spare.items() if far < KEEP}
