"""Counts the paths that `plan_path` follows, beside point-by-point IK: `python -m benchmarks.path_planning`.

With `--write` the table goes into docs/paths.md. Paths of three kinds have 200 poses: *moved*, along which the arm has
moved smoothly at random; *singular*, along which it has moved through a configuration where det J changes its sign;
*drawn*, straight between two random poses, which may leave its reach or its limits. Point-by-point IK is `solve_pose`
of each pose from the configuration before, from the arm's own first one or from rest; it follows a path if every pose
is solved and no joint moves by more than 0.35 rad between neighbours. The jump rule is MoveIt's relative one, written
anew: it ends a path at a step longer than 10 times the mean one. Travel is that of plans over that of the arm's own
motion, the median. Costs are CPU times over those of point-by-point IK on the same paths, the median.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

import robust_ik as rik
from benchmarks.all_solutions import cost, singular
from benchmarks.tables import markdown, parser, publish
from robust_ik.checks import Array
from robust_ik.paths import PosePath

ROBOTS = ("ur5", "puma560", "z1", "kinova", "panda", "xarm7")
SEED, POSES, JUMP, FACTOR, ACCURACY = 5, 200, 0.35, 10.0, 1e-3
COLUMNS = ("robot", "paths", "number", "`plan_path`", "IK, no jump", "IK, jump rule", "travel", "cost")


def swinging(robot: rik.Robot, rng: np.random.Generator, middle: Array, size: float) -> Array:
    """Joint values of a smooth motion through some in its middle, within limits, (POSES, n)."""
    low, high = np.clip(robot.lower, middle - size, None), np.clip(robot.upper, None, middle + size)
    swing = np.minimum(middle - low, high - middle) * rng.uniform(0.3, 0.9, robot.n)
    x = np.linspace(-1, 1, POSES)[:, None]
    return np.asarray(middle + swing * np.sin(0.5 * np.pi * x * rng.uniform(0.4, 1.4, robot.n)))


def moved(robot: rik.Robot, rng: np.random.Generator) -> tuple[Array, Array | None]:
    """Poses of a random motion, and its joint values."""
    values = swinging(robot, rng, robot.joint_values(robot.random(rng)), 1.2)
    return robot.pose(robot.configuration(values)), values


def through_singular(robot: rik.Robot, rng: np.random.Generator) -> tuple[Array, Array | None]:
    """Poses of a motion through a singular configuration, and its joint values."""
    values = swinging(robot, rng, robot.joint_values(singular(robot, rng, 1)[0]), 0.8)
    return robot.pose(robot.configuration(values)), values


def drawn(robot: rik.Robot, rng: np.random.Generator) -> tuple[Array, Array | None]:
    """Poses between two random ones, less than 2.8 rad apart."""
    while True:
        ends = robot.pose(robot.random(rng, 2))
        if np.trace(ends[1, :3, :3] @ ends[0, :3, :3].T) > 1 + 2 * np.cos(2.8):
            return PosePath(ends, robot.length_scale, turns=True).at(np.linspace(0, 1, POSES)), None


KINDS: dict[str, Callable[[rik.Robot, np.random.Generator], tuple[Array, Array | None]]] = {
    "moved": moved, "singular": through_singular, "drawn": drawn,
}  # fmt: skip


def point_by_point(robot: rik.Robot, poses: Array, start: Array | None) -> tuple[bool, bool]:
    """Whether IK from pose to pose follows the path without a jump, and whether the jump rule lets it pass."""
    q = robot.rest if start is None else robot.configuration(start)
    steps, solved = [], True
    for i, T in enumerate(poses):
        found = robot.solve_pose(T, q)
        solved = solved and found.solved
        d = robot.joint_values(found.q) - robot.joint_values(q)
        if i:
            steps.append(np.abs(np.where(robot.sliding, d, d - 2 * np.pi * np.round(d / (2 * np.pi)))))
        q = found.q
    sizes = np.linalg.norm(steps, axis=1)
    return solved and np.max(steps) <= JUMP, solved and bool((sizes <= FACTOR * sizes.mean()).all())


def row(name: str, kind: str, count: int) -> tuple[str, ...]:
    """What is followed of some paths of one robot."""
    robot, rng = rik.load(name), np.random.default_rng(SEED)
    followed, plain, ruled, travel, costs = [], [], [], [], []
    for _ in range(count):
        poses, values = KINDS[kind](robot, rng)
        plans: list[rik.PathPlan] = []
        ours = cost(lambda poses=poses, plans=plans: plans.append(robot.plan_path(poses, accuracy=ACCURACY)))
        done: list[tuple[bool, bool]] = []
        start = None if values is None else values[0]
        theirs = cost(lambda poses=poses, done=done, start=start: done.append(point_by_point(robot, poses, start)))
        followed.append(plans[0].followed)
        plain.append(done[0][0])
        ruled.append(done[0][1])
        costs.append(ours / theirs)
        if plans[0].followed and values is not None:
            travel.append(plans[0].pieces[0].travel / np.linalg.norm(np.diff(values, axis=0), axis=1).sum())
    return (
        name,
        kind,
        str(count),
        f"{np.mean(followed):.0%}",
        f"{np.mean(plain):.0%}",
        f"{np.mean(ruled):.0%}",
        f"{np.median(travel):.2f}" if travel else "-",
        f"{np.median(costs):.1f}",
    )


def rows(names: Sequence[str], count: int) -> list[tuple[str, ...]]:
    """The rows of all robots; singular paths are those of arms with a square Jacobian."""
    made = []
    for name in names:
        robot = rik.load(name)
        for kind in KINDS:
            if kind != "singular" or robot.n == len(robot.rows):
                made.append(row(name, kind, count))
                print(*made[-1], flush=True)
    return made


def main() -> None:
    options = parser(__doc__, "paths.md")
    options.add_argument("--count", type=int, default=30, help="paths of each kind for each robot")
    arguments = options.parse_args()
    table = markdown(COLUMNS, rows(ROBOTS, arguments.count))
    publish(table, "paths.md", "path_planning", write=arguments.write)


if __name__ == "__main__":
    main()
