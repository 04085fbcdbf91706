"""Times steps of the second-order inverse against those of J-PARSE: `python -m benchmarks.second_order_steps`.

With `--write` the table goes into docs/speed.md. Random configurations are sorted by how many singular values are
weak, below γσ₁: there the second-order inverse has a quartic to minimise. Both take turns with the same q and twist; a
number is the median ratio of CPU times of rounds.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

import robust_ik as rik
from benchmarks.tables import markdown, parser, publish
from robust_ik.inverses.task_equation import TaskEquation

GAMMA, SPEED, SEED, ROUNDS, DT = 0.08, 0.2, 1, 11, 0.01
ROBOTS = ("ur5", "puma560", "panda")
COLUMNS = ("robot", "weak singular values", "`Stepper.step`", "`inverse.velocity`", "`controller.step`")
Steps = Sequence[tuple[object, ...]]


def cost(step: Callable[..., object], steps: Steps) -> float:
    """CPU seconds of all steps."""
    begun = time.process_time()
    for each in steps:
        step(*each)
    return time.process_time() - begun


def ratio(step: Callable[..., object], base: Callable[..., object], steps: Steps) -> str:
    """The cost of one kind of step over that of another."""
    for each in (step, base):
        cost(each, steps[:3])
    return f"{np.median([cost(step, steps) / cost(base, steps) for _ in range(ROUNDS)]):.1f}"


def controlled(robot: rik.Robot, inverse: rik.RobustInverse) -> Callable[..., object]:
    """A controller's step within the robot's limits."""
    controller = rik.VelocityController(robot, inverse)
    return lambda q, task: controller.step(q, task, DT)


def row(robot: rik.Robot, weak: int, q: np.ndarray, twists: np.ndarray) -> tuple[str, ...]:
    """The ratios at configurations with so many weak singular values."""
    curved, filtered = rik.SecondOrder(GAMMA), rik.JParse(GAMMA)
    out = np.empty(robot.n)
    steps = [(each, twist, out) for each, twist in zip(q, twists)]
    hessians = robot.hessian(q)
    equations = [(TaskEquation(*each),) for each in zip(robot.jacobian(q), twists, twists, hessians)]
    targets = []
    for each, twist in zip(q, twists):
        target = np.array(robot.pose(each))
        target[:3, 3] += DT * twist[:3]
        targets.append((each, rik.FrameTask(target, gain=1 / DT)))
    return (
        robot.name,
        str(weak),
        ratio(rik.Stepper(robot, curved).step, rik.Stepper(robot, filtered).step, steps),
        ratio(curved.begin(DT).velocity, filtered.velocity, equations),
        ratio(controlled(robot, curved), controlled(robot, filtered), targets[:100]),
    )


def rows(names: Sequence[str], drawn: int, count: int) -> list[tuple[str, ...]]:
    """All rows: of each robot for every number of weak singular values that random configurations often have."""
    found = []
    for name in names:
        robot, rng = rik.load(name), np.random.default_rng(SEED)
        q, twists = robot.random(rng, drawn), SPEED * rng.normal(size=(drawn, len(robot.rows)))
        s = rik.svd(robot.jacobian(q)).s
        weak = np.sum(s < GAMMA * s[:, :1], axis=1)
        for number in range(3):
            chosen = np.flatnonzero(weak == number)[:count]
            if len(chosen) >= count // 10:
                found.append(row(robot, number, q[chosen], twists[chosen]))
    return found


def main() -> None:
    options = parser(__doc__, "speed.md")
    options.add_argument("--count", type=int, default=400, help="configurations of each row")
    arguments = options.parse_args()
    table = markdown(COLUMNS, rows(ROBOTS, 50 * arguments.count, arguments.count))
    publish(table, "speed.md", "second_order_steps", write=arguments.write)


if __name__ == "__main__":
    main()
