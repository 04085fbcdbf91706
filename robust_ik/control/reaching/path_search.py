"""Ways through joint space past what forbids configurations; searched in small pieces, so that nobody waits long.

Source: Kuffner & LaValle 2000 (RRT-Connect), with shortcuts; the same random numbers for every search.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.reaching.space import LOOK, Space

Pieces = Generator[None, None, Any]
"""Yields after each look at a configuration, the costly part; then returns what was found."""

KEEP = 0.003
"""m that a way keeps from what is forbidden, besides."""
LEAST_MOVE = 0.01
"""m that points of the robot may move between two looks, however near something is."""
GROWTH = 0.4
"""rad or m by which a tree grows at once."""
NODES, SHORTCUTS = 1500, 80
"""Of both trees; and tries to make a way shorter."""
AROUND = 1.6
"""rad or m beyond start and goals where ways are looked for."""
FULL = 1e-9
"""m or rad: lacking room, or way, below this counts as none. Chosen: far above rounding, far below what matters."""


class PathSearch:
    """A search from one start to any of some goals.

    What is already nearer to being forbidden than a way should be, at the start or at a goal, may be as near as there.
    """

    def __init__(self, space: Space, start: Array, goals: Array) -> None:
        self.space, self.start, self.goals = space, start, goals
        self._floors = _halved(space.spare(start))
        self._rng = np.random.default_rng(0)

    def free_goals(self) -> Pieces:
        """Which goals may be stood at, (g,) of bool."""
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
        """Whether the straight way from a to b, without its start, can be gone."""
        change = b - a
        moved = float(np.abs(change) @ self.space.lever)  # m, at most
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
        """Points of a way from the start to one of the goals, (k, n); None where none is found."""
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
        """The last node on the way of a tree towards a point, None where it cannot grow."""
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
        """A shorter way, by straight ones between two places of it."""
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
        """Without the points that can be left out."""
        kept, index = [points[0]], 0
        while index < len(points) - 1:
            for to in range(len(points) - 1, index, -1):
                if to == index + 1 or (yield from self.is_free(points[index], points[to])):
                    break
            index = to
            kept.append(points[index])
        return np.array(kept)


class Tree:
    """Points, each with the one that it was reached from; the first ones are roots."""

    def __init__(self, roots: Array) -> None:
        self.points = list(roots)
        self._from = [-1] * len(roots)

    def __len__(self) -> int:
        return len(self.points)

    def nearest(self, x: Array) -> int:
        """The nearest point's index."""
        return int(np.argmin(((np.array(self.points) - x) ** 2).sum(axis=1)))

    def add(self, x: Array, before: int) -> int:
        """Its index."""
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
    """How near may be come to what is nearer than `KEEP`: half as near, or, where it is too near, no nearer."""
    return {name: far / 2 if far > 0 else far for name, far in spare.items() if far < KEEP}
