"""Plans the quickest path found from a configuration to one of the configurations that reach a pose."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.reaching.goals import GoalFinder
from robust_ik.control.reaching.path import Caps, Path
from robust_ik.control.reaching.path_search import PathSearch
from robust_ik.control.reaching.search_space import Space
from robust_ik.control.tasks.frame import FrameTask

SHOULDER, WRIST = 0.25, 0.66
"""Fractions of the length of a chain where its shoulder ends and its wrist begins."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A path, and the error at its end.

    Attributes:
        path: The path; None if none was found.
        error: Distance of the pose at its end from the target, m and rad; zero if it is reached.
    """

    path: Path | None
    error: tuple[float, float]

    @property
    def reaches(self) -> bool:
        """Whether it leads to the target itself."""
        return self.error == (0.0, 0.0)


def plan(space: Space, finder: GoalFinder, task: FrameTask, x: Array) -> Generator[None, None, Plan]:
    """Looks for a path from x, (n,), in pieces; then returns the plan."""
    goals, caps = finder.all(task, x), Caps.of(task, space)
    straight: list[tuple[float, int, Path]] = []
    for goal in goals.points:
        path = Path(space, np.stack([x, goal]), caps)
        straight.append((path.duration, len(straight), path))
        yield
    paths = [path for _, _, path in sorted(straight, key=lambda each: each[:2])]
    if not space.watching:
        return Plan(paths[0], goals.error)
    found = yield from _past_obstacles(space, paths, x)
    return Plan(found, goals.error)


def _past_obstacles(space: Space, paths: list[Path], x: Array) -> Generator[None, None, Path | None]:
    """The first straight way that is free; otherwise a path found by a search; None if there is none."""
    search = PathSearch(space, x, np.array([path.goal for path in paths]))
    free = yield from search.free_goals()
    open_paths = [path for path, is_free in zip(paths, free) if is_free]
    for path in open_paths:
        if (yield from search.is_free(x, path.goal)):
            return path
    if not open_paths:
        return None
    points = yield from search.connect(np.array([path.goal for path in open_paths]))
    if points is None:
        return None
    points = yield from search.shortened(points)
    return Path(space, points, paths[0].caps)


def what_turns(path: Path) -> str:
    """The part of the arm that a path turns most, and its joint."""
    space = path.space
    joint = int(np.argmax(np.abs(np.diff(path.points, axis=0)).sum(axis=0)))
    name = space.robot.joint_names[joint]
    chain = space.robot.chain(space.frame)
    along = np.cumsum(np.linalg.norm(np.concatenate([0 * chain.origins[:1], chain.origins[1:]]), axis=1))
    length = along[-1] + float(np.linalg.norm(chain.tip[:3, 3]))
    places = along[chain.column == joint]
    if space.robot.sliding[joint] or length <= 0 or not len(places):
        return name
    share = places[0] / length
    return f"{'shoulder' if share < SHOULDER else 'wrist' if share > WRIST else 'elbow'} ({name})"
