"""Times the control loop within limits: prepared, plain, many at once, and as a simulation.

`python -m benchmarks.loop_steps` prints a table. The unit is one `J.T @ np.linalg.solve(J @ J.T + λI, v)` of a 6×7 J,
timed in the same process between the others: what a person pays who writes damped least squares by hand, without
kinematics, limits or posture. A Panda's hand first, its posture second; CPU time of one core, medians over
configurations.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable

import numpy as np

import robust_ik as rik
from benchmarks.tables import markdown, parser, publish

DT, SEED, GAIN = 0.01, 1, 100.0
FAR, NEAR = 0.05, 0.002
"""Distances of targets, m: the whole way in one step is beyond the speed limits, or within."""
MANY, STEPS = 64, 500
"""Runs side by side, and their steps."""
COLUMNS = (
    "within", "prepared, far", "near", "p99.9 / median", "plain, same tasks", "plain, new tasks", "to make the tasks",
)  # fmt: skip


def cost(work: Callable[[], object], repeats: int) -> float:
    """CPU seconds of a call: the median of five rounds."""
    rounds = []
    for _ in range(5):
        begun = time.process_time()
        for _ in range(repeats):
            work()
        rounds.append((time.process_time() - begun) / repeats)
    return float(np.median(rounds))


def unit(robot: rik.Robot) -> float:
    """CPU seconds of the unit."""
    J, damping, v = robot.jacobian(robot.rest), 1e-4 * np.eye(6), np.ones(6)
    return cost(lambda: J.T @ np.linalg.solve(J @ J.T + damping, v), 1000)


def tail(loop: rik.ControlLoop, q: np.ndarray, out: np.ndarray) -> float:
    """The 99.9 % quantile of single steps over their median, on the clock."""
    times = np.empty(20_000)
    for index in range(len(times)):
        begun = time.perf_counter_ns()
        loop.step(q, out)
        times[index] = time.perf_counter_ns() - begun
    return float(np.quantile(times, 0.999) / np.median(times))


def moves(robot: rik.Robot, distance: float, count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Configurations anywhere, and targets that far away in any direction."""
    rng, found = np.random.default_rng(SEED), []
    for q in robot.random(rng, count):
        target, aside = np.array(robot.pose(q)), rng.normal(size=3)
        target[:3, 3] += distance * aside / np.linalg.norm(aside)
        found.append((q, target))
    return found


def row(name: str, controller: rik.VelocityController, between: list[list[rik.Task]], count: int) -> tuple[str, ...]:
    """The costs of one kind of stack and limits, in units."""
    robot, out = controller.robot, np.empty(controller.robot.n)

    def stack(target: np.ndarray) -> list[list[rik.Task]]:
        return [[rik.FrameTask(target, gain=GAIN)], *between, [rik.PostureTask(robot.rest, gain=GAIN)]]

    found: dict[str, list[float]] = {each: [] for each in ("far", "near", "same", "new", "made")}
    for kind, distance in (("far", FAR), ("near", NEAR)):
        for q, target in moves(robot, distance, count):
            one, same = unit(robot), stack(target)
            loop = rik.ControlLoop(controller, same, DT)
            found[kind].append(cost(lambda loop=loop, q=q: loop.step(q, out), 200) / one)
            if kind == "near":
                continue
            controller.reset()
            found["same"].append(cost(lambda q=q, same=same: controller.step(q, same, DT), 50) / one)
            fresh = itertools.cycle([stack(target) for _ in range(300)])  # more than five rounds take
            found["new"].append(cost(lambda q=q, fresh=fresh: controller.step(q, next(fresh), DT), 50) / one)
            found["made"].append(cost(lambda target=target: stack(target), 50) / one)
    medians = {each: float(np.median(costs)) for each, costs in found.items()}
    cells = [f"{medians[each]:.2f}" for each in ("far", "near")]
    rest = [f"{medians[each]:.1f}" for each in ("same", "new", "made")]
    return (name, *cells, f"{tail(loop, q, out):.1f}", *rest)


def together(robot: rik.Robot) -> tuple[str, str]:
    """Units a step and core of many runs side by side, and of a simulated run."""
    rng = np.random.default_rng(SEED)
    starts, targets = robot.random(rng, MANY), robot.pose(robot.random(rng, MANY))
    stack = [[rik.FrameTask(np.eye(4), gain=5.0, max_linear=0.2, max_angular=1.0)], [rik.PostureTask(robot.rest)]]
    loop = rik.ControlLoop(rik.VelocityController(robot), stack, DT)
    numbers = {(0, 0): {"target": targets}}
    many = cost(lambda: loop.runs(starts, STEPS, every=STEPS, numbers=numbers), 1) / (MANY * STEPS) / unit(robot)
    goal = [[rik.FrameTask(targets[0], gain=5.0, max_linear=0.2)], [rik.PostureTask(robot.rest)]]
    run = cost(lambda: rik.simulate(robot, None, goal, robot.rest, duration=20.0, dt=DT, progress=untold), 1)
    return f"{many:.2f}", f"{run / 2000 / unit(robot):.1f}"


def untold(done: int, total: int) -> None:
    """Ignores progress."""


def main() -> None:
    options = parser(__doc__, "speed.md")
    options.add_argument("--count", type=int, default=25, help="configurations")
    arguments = options.parse_args()
    robot = rik.load("panda")
    limits = rik.JointLimits.of(robot)
    hurried = rik.JointLimits.of(robot, acceleration=10.0)
    program = rik.TaskPriority(rik.JParse(0.01), rik.QuadraticProgram(), steady=True)
    kinds: list[tuple[str, rik.VelocityController, list[list[rik.Task]]]] = [
        ("position and speed limits", rik.VelocityController(robot, limits=limits), []),
        ("acceleration limits too", rik.VelocityController(robot, limits=hurried), []),
        ("a SingularValueTask between", rik.VelocityController(robot, limits=limits), [[rik.SingularValueTask()]]),
        ("`QuadraticProgram`", rik.VelocityController(robot, program, limits), []),
    ]
    rows = [row(*kind, arguments.count) for kind in kinds]
    many, run = together(robot)
    told = f"Of many runs side by side a step costs {many} units of a core, of a simulated run with its record {run}."
    publish(f"{markdown(COLUMNS, rows)}\n\n{told}", "speed.md", "loop_steps", write=arguments.write)


if __name__ == "__main__":
    main()
