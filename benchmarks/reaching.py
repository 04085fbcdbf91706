"""Drives `rik.Reach` in closed loop from random starts to random targets, and tells who gets there, when, within what.

`python -m benchmarks.reaching` runs every arm within its joint and speed limits, tool speeds capped; `--limits` takes
acceleration limits, or a table with collision limits in their place. Two thirds of the targets are poses of random
configurations within the limits, the others lie out of reach. The time is told as a multiple of what the quickest
straight way through joint space to a solution takes at the same limits and caps, the time of servoing aside. With
`--gamma` the controller has another J-PARSE than it has by default; such tables are only printed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import robust_ik as rik
from benchmarks.environments import progress
from benchmarks.tables import markdown, parser, publish
from robust_ik.control.reaching.goals import GoalFinder
from robust_ik.control.reaching.path import Caps, Path
from robust_ik.control.reaching.search_space import Space

ARMS = ("xarm7", "panda", "kinova", "ur5", "ur10", "z1", "so101", "puma560", "pa10", "kinova_gen3")
GAIN, LINEAR, ANGULAR, DT, SEED = 5.0, 0.05, 0.2, 0.01, 15
"""The task's gain and caps on the error, so that the tool moves at 0.25 m/s and 1 rad/s at most."""
LONGEST, REACHED, RESTS = 60.0, 1e-6, 1e-6
KINDS = ("speed", "acceleration", "table")
COLUMNS = (
    "arm", "reachable", "reached to 1e-6", "of these by going round", "time beside the joints' own: median", "largest",
    "out of reach", "at rest within 1 % of the closest", "worst violation",
)  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """Of one run.

    Attributes:
        solvable: Whether the target can be reached.
        error: What is left, m and rad together.
        ratio: Time but for servoing, over the quickest way's.
        round: Whether it went round.
        rests: Whether joints are at rest at the end.
        over: The largest violation of a limit or cap.
    """

    solvable: bool
    error: float
    ratio: float
    round: bool
    rests: bool
    over: float


def limits_of(robot: rik.Robot, kind: str) -> list[rik.Limit]:
    """What is respected."""
    if kind == "acceleration":
        return [rik.JointLimits.of(robot, acceleration=5.0)]
    table = rik.Obstacle("table", rik.HalfSpace((0, 0, 1), -0.05))
    around = [rik.CollisionLimit.of(robot, obstacles=[table])] if kind == "table" else []
    return [rik.JointLimits.of(robot), *around]


def any_pose(robot: rik.Robot, limits: list[rik.Limit], rng: np.random.Generator) -> np.ndarray:
    """A configuration that no limit forbids."""
    while True:
        q = robot.random(rng)
        distances = [near.distance - 0.02 for each in limits[1:] for near in each.distances(robot, q)[:1]]
        if min(distances, default=1.0) > 0:
            return q


def over(robot: rik.Robot, limits: list[rik.Limit], q: np.ndarray, qdot: np.ndarray) -> float:
    """By how much a step is beyond a limit or a cap: rad/s, m/s, rad, m."""
    twist, values, joints = robot.jacobian(q, rows=("x", "y", "z", "wx", "wy", "wz")) @ qdot, robot.joint_values(q), limits[0]  # fmt: skip  # noqa: E501
    distances = [each.distance - near.distance for each in limits[1:] for near in each.distances(robot, q)[:1]]
    return max(
        float(np.linalg.norm(twist[:3])) - GAIN * LINEAR if "x" in robot.rows else 0.0,
        float(np.linalg.norm(twist[3:])) - GAIN * ANGULAR if len(robot.rows) == 6 else 0.0,
        *(np.abs(qdot) - joints.velocity),
        *(values - joints.upper),
        *(joints.lower - values),
        *distances,
    )


def least_time(robot: rik.Robot, task: rik.Reach, limits: list[rik.Limit], q: np.ndarray) -> float:
    """Seconds of the quickest straight way through joint space to a solution."""
    space = Space.of(robot, None, limits)
    start = space.values(q)
    caps = Caps.of(task, space)
    goals = GoalFinder(space).all(task, start).points
    return min(Path(space, np.stack([start, goal]), caps).duration for goal in goals)


def run(
    robot: rik.Robot, limits: list[rik.Limit], q: np.ndarray, target: np.ndarray, inverse: rik.JParse | None = None
) -> Outcome:
    """One closed loop, until it rests."""
    task = rik.Reach(target, gain=GAIN, max_linear=LINEAR, max_angular=ANGULAR)
    controller, start = rik.VelocityController(robot, inverse, limits), q
    worst, straight, reached, went_round, speeds, previous = 0.0, 0.0, np.inf, False, [np.inf], np.zeros(robot.n)
    error = np.inf
    for step in range(int(LONGEST / DT)):
        qdot = controller.step(q, task, DT).qdot
        hurry = (np.abs(qdot - previous) / DT - limits[0].acceleration).max()
        worst = max(worst, over(robot, limits, q, qdot), float(hurry))
        straight += DT * (task.state == "servoing")
        went_round |= task.state.startswith("going round")
        q, previous = robot.integrate(q, DT * qdot), qdot
        error = float(np.linalg.norm(task.equation(robot, q).error))
        reached = min(reached, (step + 1) * DT) if error < REACHED else np.inf
        speeds.append(float(np.abs(qdot).max()))
        if max(speeds[-50:]) < RESTS and task.state not in ("servoing", "planning"):
            break
    closest = robot.solve_pose(target, start, effort="thorough")
    missed = 0.0 if closest.solved else float(np.hypot(*closest.error))
    ratio = (reached - straight) / max(least_time(robot, task, limits, start), DT)
    excess = 0.0 if closest.solved else error / missed - 1
    return Outcome(closest.solved, error if closest.solved else excess, ratio, went_round, speeds[-1] < RESTS, worst)


def targets(robot: rik.Robot, limits: list[rik.Limit], count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Starts and targets, always the same."""
    rng = np.random.default_rng(SEED)
    found = []
    for number in range(count):
        q, target = any_pose(robot, limits, rng), robot.pose(any_pose(robot, limits, rng))
        if number % 3 == 2:
            target[:3, 3] *= 1.3 * robot.size / np.linalg.norm(target[:3, 3])
        found.append((q, target))
    return found


def row(name: str, kind: str, count: int, inverse: rik.JParse | None = None) -> tuple[str, ...]:
    """An arm's line of the table."""
    robot = rik.load(name)
    limits = limits_of(robot, kind)
    made = [run(robot, limits, q, target, inverse) for q, target in targets(robot, limits, count)]
    near, far = [each for each in made if each.solvable], [each for each in made if not each.solvable]
    there = [each for each in near if each.error < REACHED]
    ratios = [max(each.ratio, 0.0) for each in there]
    resting = sum(each.rests and each.error < 0.01 for each in far)
    return (
        name, str(len(near)), str(len(there)), str(sum(each.round for each in there)),
        f"{np.median(ratios):.2f}" if ratios else "–", f"{max(ratios):.2f}" if ratios else "–",
        str(len(far)), str(resting), f"{max(each.over for each in made):.1e}",
    )  # fmt: skip


def main() -> None:
    options = parser(__doc__, "task_stacks.md")
    options.add_argument("--pairs", type=int, default=60, help="of every arm")
    options.add_argument("--arms", nargs="+", default=ARMS)
    options.add_argument("--limits", choices=KINDS, default="speed")
    options.add_argument("--gamma", type=float, help="of the J-PARSE; default that of a controller")
    arguments = options.parse_args()
    inverse = None if arguments.gamma is None else rik.JParse(arguments.gamma)
    rows = []
    for name in arguments.arms:
        progress.print(f"{name}: {arguments.pairs} runs")
        rows.append(row(name, arguments.limits, arguments.pairs, inverse))
    mark = {"speed": "reaching", "acceleration": "reaching-acceleration", "table": "reaching-table"}[arguments.limits]
    publish(markdown(COLUMNS, rows), "task_stacks.md", mark, write=arguments.write and inverse is None)


if __name__ == "__main__":
    main()
