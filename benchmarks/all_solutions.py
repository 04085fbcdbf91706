"""Counts what `all_solutions` finds, and what it costs: `python -m benchmarks.all_solutions`.

With `--write` the table goes into docs/all_solutions.md. A random configuration must be among the solutions of its
pose, or on one of their self-motions; so must one at which det J is zero along a joint. Costs are CPU times over those
of `solve_pose` from q0 = rest on the same poses, both in turn: the median ratio of rounds.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

import robust_ik as rik
from benchmarks.tables import markdown, parser, publish
from robust_ik.checks import Array

ROBOTS = ("ur5", "puma560", "z1", "kinova", "so101", "duleba_3r")
SEED, ROUNDS, TIMED = 3, 11, 200
COLUMNS = (
    "robot",
    "method",
    "poses",
    "found",
    "complete",
    "solutions",
    "singular poses",
    "found",
    "`all_solutions`",
    "batch",
)


def apart(robot: rik.Robot, a: Array, b: Array) -> float:
    """The least difference of configurations (s, nq) from one, turns modulo 2π."""
    d = robot.joint_values(a) - robot.joint_values(b)
    d = np.where(robot.sliding, d, d - 2 * np.pi * np.round(d / (2 * np.pi)))
    return float(np.abs(d).max(axis=-1).min()) if len(d) else np.inf


def holds(robot: rik.Robot, found: rik.AllSolutions, q: Array) -> bool:
    """Whether q is a solution, or lies on a self-motion."""
    return apart(robot, found.q, q) < 1e-3 or any(apart(robot, curve.q, q) < 0.15 for curve in found.self_motions)


def singular(robot: rik.Robot, rng: np.random.Generator, count: int) -> list[Array]:
    """Configurations at which det J changes its sign along a joint, by bisection; none if J is not square."""
    found: list[Array] = []
    square = robot.n == len(robot.rows)
    while square and len(found) < count:
        values = robot.joint_values(robot.random(rng))
        joint = int(rng.integers(1, robot.n - 1)) if robot.n > 2 else 1
        grid = np.repeat(values[None], 41, axis=0)
        grid[:, joint] = np.linspace(max(robot.lower[joint], -np.pi), min(robot.upper[joint], np.pi), 41)
        det = np.linalg.det(robot.jacobian(robot.configuration(grid))[:, [rows_of(row) for row in robot.rows]])
        changes = np.flatnonzero(det[:-1] * det[1:] < 0)
        if not len(changes):
            continue
        i = int(rng.choice(changes))
        low, high = grid[i, joint], grid[i + 1, joint]
        for _ in range(60):
            values[joint] = 0.5 * (low + high)
            J = robot.jacobian(robot.configuration(values))[[rows_of(row) for row in robot.rows]]
            low, high = (values[joint], high) if np.linalg.det(J) * det[i] > 0 else (low, values[joint])
        found.append(robot.configuration(values))
    return found


def rows_of(row: str) -> int:
    """Place of a row among the six."""
    return ("x", "y", "z", "wx", "wy", "wz").index(row)


def cost(call: Callable[[], object]) -> float:
    """CPU seconds of a call."""
    begun = time.process_time()
    call()
    return time.process_time() - begun


def row(name: str, count: int, few: int) -> tuple[str, ...]:
    """What is found of one robot, and what it costs."""
    robot, rng = rik.load(name), np.random.default_rng(SEED)
    q = robot.random(rng, count)
    T = np.ascontiguousarray(robot.pose(q))
    many = robot.all_solutions_many(T)
    hit = [apart(robot, s[:n], one) < 1e-6 for s, n, one in zip(many.q, many.found, q)]
    special = singular(robot, rng, few)
    kept = [holds(robot, robot.all_solutions(robot.pose(one)), one) for one in special]
    timed = T[:TIMED]
    single, batch = [], []
    for _ in range(ROUNDS):
        base = cost(lambda: [robot.solve_pose(one) for one in timed])
        single.append(cost(lambda: [robot.all_solutions(one) for one in timed]) / base)
        batch.append(cost(lambda: robot.all_solutions_many(timed)) / base)
    counts = many.found + many.beyond
    return (
        name,
        robot.branch_solver().method,
        str(count),
        f"{np.mean(hit):.2%}",
        f"{many.complete.mean():.2%}",
        f"{counts.min()} to {counts.max()}",
        str(len(special)) if special else "-",
        f"{np.mean(kept):.2%}" if special else "-",
        f"{np.median(single):.1f}",
        f"{np.median(batch):.1f}",
    )


def rows(names: Sequence[str], count: int, few: int) -> list[tuple[str, ...]]:
    """The rows of all robots."""
    return [row(name, count, few) for name in names]


def main() -> None:
    options = parser(__doc__, "all_solutions.md")
    options.add_argument("--count", type=int, default=10_000, help="random poses of each robot")
    options.add_argument(
        "--singular", type=int, default=200, help="singular poses of each robot with a square Jacobian"
    )
    arguments = options.parse_args()
    table = markdown(COLUMNS, rows(ROBOTS, arguments.count, arguments.singular))
    publish(table, "all_solutions.md", "all_solutions", write=arguments.write)


if __name__ == "__main__":
    main()
