"""Times the inverse of a pose within joint limits, and counts what is missed: ours and its peers, four arms.

`python -m benchmarks.pose_ik` prints the table; with `--write` it goes into docs/benchmarks.md, JSON and figure beside
it. Targets: reachable from random starts; from a start 0.05 rad away; exactly singular; 1.1 and 2 times the reach away.
All get the same starts and targets and take turns. Every answer is judged by Pinocchio's forward kinematics, whatever
its solver says: solved is 1e-4 m, 1e-3 rad and within the limits. Out of reach counts the error √(m² + rad²) over the
least that anyone, or many thorough solves, came to. `benchmarks.pose_accuracy` counts misses among 50,000 targets.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

import robust_ik as rik
from benchmarks import figures
from benchmarks.chains import Chain
from benchmarks.environments import CACHE
from benchmarks.peers.timing import Sample, error
from benchmarks.report import Report, options
from benchmarks.rounds import Contender, Round, Series, batches, calls, interleave, needed, ours, peer, spread
from benchmarks.works import KINDS, TOLERANCE, arm, pinocchio_pose, poses, work_of

ROBOTS = ("panda", "ur5", "pa10", "xarm7")
OURS, THOROUGH = "robust_ik", "robust_ik thorough"
PEERS = {
    "Robotics Toolbox ik_LM": "roboticstoolbox", "TRAC-IK": "pytracik", "PyKDL LMA": "pykdl",
    "RoboPlan SimpleIk": "roboplan", "EmbodiK": "embodik", "Pink": "pink", "mink": "mink", "EAIK": "eaik",
}  # fmt: skip
SLOW = {"EmbodiK", "Pink", "mink"}
"""Tens of milliseconds a target: they get few; of targets out of reach all get few, and these a fifth of them."""
COLUMNS = (
    "robot", "targets", "system", "CPU [µs]", "median [µs]", "p99 [µs]", "solved", "to 1e-8", "error / best: median",
    "… p90", "ratio to ours",
)  # fmt: skip


def solving(robot: rik.Robot, q0: np.ndarray, targets: np.ndarray, **settings: Any) -> Round:
    """The round of our own solver, one target at a time."""
    solve = needed(robot, "solve_pose")

    def usual(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        return solve(target, q0=q).q

    def otherwise(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        return solve(target, q0=q, **settings).q

    return calls(otherwise if settings else usual, q0, targets)


def batch(robot: rik.Robot, q0: np.ndarray, targets: np.ndarray) -> Round:
    """The round of our own solver, all targets at once."""
    solve = needed(robot, "solve_poses")
    round_ = batches(lambda: solve(targets, q0=q0), len(targets), 3)

    def judged() -> Sample:
        done = round_()
        return Sample(done.cpu_us, done.us, done.answers.q)

    return judged


def contenders(
    robot: rik.Robot, chain: Chain, q0: np.ndarray, targets: np.ndarray, kind: str, peers: Sequence[str], few: int
) -> list[Contender]:
    """Everyone for one kind of targets."""
    found = [
        ours(OURS, lambda: solving(robot, q0, targets)),
        ours("robust_ik batch", lambda: batch(robot, q0, targets)),
    ]
    away = kind.startswith("unreachable")
    if away:
        found.append(ours(THOROUGH, lambda: solving(robot, q0, targets, effort="thorough")))
    for name in peers:
        count = (max(few // 5, 1) if away else few) if name in SLOW else (few if away else len(q0))
        path = CACHE / f"poses_{count}.npz"
        work_of(robot, chain, q0[:count], targets[:count]).save(path)
        found.append(peer(name, PEERS[name], "pose", path))
    return found


def best_known(robot: rik.Robot, targets: np.ndarray, answers: Sequence[np.ndarray], solves: int) -> np.ndarray:
    """The least error that anyone came to within the limits, many thorough solves of ours among them, (N,)."""
    least = np.full(len(targets), np.inf)
    fk, rng = pinocchio_pose(robot), np.random.default_rng(2)
    found = list(answers)
    if hasattr(robot, "solve_poses"):
        starts = (robot.random(rng, len(targets)) for _ in range(solves))
        found += [robot.solve_poses(targets, q0=q0, effort="thorough").q for q0 in starts]
    for q in found:
        far = np.hypot(*error(fk(q), targets[: len(q)]).T)
        least[: len(q)] = np.fmin(least[: len(q)], np.where(inside(robot, q), far, np.inf))
    return least


def inside(robot: rik.Robot, q: np.ndarray) -> np.ndarray:
    """Which configurations are within the limits, but for rounding in single precision, (N,)."""
    return ((q >= robot.lower - 1e-6) & (q <= robot.upper + 1e-6)).all(axis=1)


def judge(robot: rik.Robot, each: Series, targets: np.ndarray, best: np.ndarray | None) -> dict[str, Any]:
    """Shares of targets solved, and for targets out of reach how near answers come."""
    q = each.answers
    missing = error(pinocchio_pose(robot)(q), targets[: len(q)])
    kept = inside(robot, q)
    verdict: dict[str, Any] = {
        "targets": len(q),
        "solved": float(((missing < TOLERANCE).all(axis=1) & kept).mean()),
        "to 1e-8": float(((missing < 1e-8).all(axis=1) & kept).mean()),
        "within limits": float(kept.mean()),
    }
    if best is not None:
        over = np.where(kept, np.hypot(*missing.T) / best[: len(q)], np.inf)
        middle, p90 = np.percentile(over, (50, 90), method="higher")
        verdict["error over best"] = {"median": _finite(middle), "p90": _finite(p90), "worst": _finite(over.max())}
    return verdict


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def row(robot: str, kind: str, each: Series, verdict: dict[str, Any], own: Series) -> Sequence[str]:
    """A line of the table."""
    if each.failure:
        return robot, kind, each.name, *("–",) * 7, each.failure
    over = verdict.get("error over best", {})
    shares = ("–", "–") if over else (f"{100 * verdict[key]:.4g} %" for key in ("solved", "to 1e-8"))
    near = ("–" if over.get(key) is None else f"{over[key]:.4g}" for key in ("median", "p90"))
    times = (np.median(each.cpu), np.median(each.us), np.percentile(each.us, 99))
    name = f"{each.name} {each.version}".strip()
    return robot, kind, name, *(f"{value:.3g}" for value in times), *shares, *near, each.ratio(own)


def measure(name: str, kind: str, arguments: Any) -> tuple[list[Sequence[str]], dict[str, Any]]:
    """All systems on one arm and one kind of targets."""
    robot, chain = arm(name)
    q0, targets = poses(robot, kind, arguments.targets)
    peers = () if arguments.no_peers else tuple(PEERS)
    everyone = contenders(robot, chain, q0, targets, kind, peers, min(arguments.few, arguments.targets))
    series = interleave(everyone, arguments.rounds)
    answers = [each.answers for each in series.values() if each.samples]
    best = best_known(robot, targets, answers, arguments.solves) if kind.startswith("unreachable") else None
    rows, results = [], {}
    for label, each in series.items():
        verdict = judge(robot, each, targets, best) if each.samples else {}
        rows.append(row(name, kind, each, verdict, series[OURS]))
        results[label] = {**each.summary([series[OURS]]), **verdict}
    return rows, results


def main() -> None:
    parser = options(__doc__)
    parser.set_defaults(rounds=3)
    parser.add_argument("--robots", nargs="*", default=ROBOTS)
    parser.add_argument("--kinds", nargs="*", default=KINDS, help=", ".join(KINDS))
    parser.add_argument("--targets", type=int, default=500)
    parser.add_argument("--few", type=int, default=50, help="targets for systems of tens of milliseconds")
    parser.add_argument("--solves", type=int, default=30, help="thorough ones that tell the best known error")
    arguments = parser.parse_args()
    rows, results = [], {}
    for name in arguments.robots:
        for kind in arguments.kinds:
            lines, results[f"{name}, {kind}"] = measure(name, kind, arguments)
            rows += lines
    bars = {
        title: {label: spread(np.array(each["cpu_us_of_rounds"])) for label, each in group.items() if "cpu_us" in each}
        for title, group in results.items()
        if title.endswith((", random", ", warm"))
    }
    settings = {key: value for key, value in vars(arguments).items() if key not in ("write", "no_peers")}
    draw = partial(figures.bars, groups=bars, label="CPU µs a pose, median and quartiles of rounds") if bars else None
    Report("pose_ik", COLUMNS, rows, results, settings, text_last=True, figure=draw).publish(write=arguments.write)


if __name__ == "__main__":
    main()
