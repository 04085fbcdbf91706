"""Counts the poses that our solver misses: random reachable targets, random starts, within the limits, four arms.

`python -m benchmarks.pose_accuracy` prints the table; with `--write` it goes into docs/benchmarks.md. Every answer is
judged by Pinocchio's forward kinematics, and by the limits themselves. "Singular" targets are exactly singular.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.environments import UnavailableError, progress
from benchmarks.peers.timing import error
from benchmarks.pose_ik import ROBOTS
from benchmarks.report import Report, options
from benchmarks.rounds import needed
from benchmarks.works import TOLERANCE, arm, pinocchio_pose, poses

CHUNK = 5000
FINE = 1e-8
COLUMNS = (
    "robot", "targets", "count", "missed at 1e-4 m, 1e-3 rad", "missed at 1e-8", "outside limits",
    "claimed but missed", "CPU [µs]", "starts: mean", "… largest",
)  # fmt: skip


def count(name: str, kind: str, targets: int) -> dict[str, Any]:
    """All solves of one arm and one kind of targets."""
    robot, _ = arm(name)
    solve = needed(robot, "solve_poses")
    fk, totals, statuses = pinocchio_pose(robot), Counter[str](), Counter[str]()
    cpu, largest = 0, 0
    for number, begin in enumerate(range(0, targets, CHUNK)):
        q0, wanted = poses(robot, kind, min(CHUNK, targets - begin), seed=100 + number)
        start = time.process_time_ns()
        found = solve(wanted, q0=q0)
        cpu += time.process_time_ns() - start
        missing = error(fk(found.q), wanted)
        kept = ((found.q >= robot.lower) & (found.q <= robot.upper)).all(axis=1)
        coarse, fine = (missing < TOLERANCE).all(axis=1), (missing < FINE).all(axis=1)
        claimed = (np.asarray(found.error) < FINE).all(axis=1)
        totals += Counter(
            missed=int((~(coarse & kept)).sum()), missed_fine=int((~(fine & kept)).sum()), outside=int((~kept).sum()),
            claimed=int((claimed & ~(missing < 2 * FINE).all(axis=1)).sum()), starts=int(np.sum(found.starts)),
        )  # fmt: skip
        statuses.update(str(each) for each in np.ravel(found.status))
        largest = max(largest, int(np.max(found.starts)))
    return {
        "targets": targets,
        **{key: totals[key] for key in ("missed", "missed_fine", "outside", "claimed")},
        "cpu_us": 1e-3 * cpu / targets,
        "starts": {"mean": totals["starts"] / targets, "largest": largest},
        "statuses": dict(statuses),
    }


def row(name: str, kind: str, found: dict[str, Any]) -> Sequence[str]:
    """A line of the table."""
    counts = (str(found[key]) for key in ("targets", "missed", "missed_fine", "outside", "claimed"))
    starts = found["starts"]
    return name, kind, *counts, f"{found['cpu_us']:.3g}", f"{starts['mean']:.3g}", str(starts["largest"])


def main() -> None:
    parser = options(__doc__)
    parser.add_argument("--robots", nargs="*", default=ROBOTS)
    parser.add_argument("--kinds", nargs="*", default=("random", "singular"))
    parser.add_argument("--targets", type=int, default=50_000)
    arguments = parser.parse_args()
    rows, results = [], {}
    for name in arguments.robots:
        for kind in arguments.kinds:
            progress.print(f"{name}, {kind}")
            try:
                results[f"{name}, {kind}"] = found = count(name, kind, arguments.targets)
                rows.append(row(name, kind, found))
            except UnavailableError as reason:
                results[f"{name}, {kind}"] = {"failure": str(reason)}
                rows.append((name, kind, *("–",) * 7, str(reason)))
    settings = {"targets": arguments.targets, "tolerance": TOLERANCE, "fine": FINE}
    Report("pose_accuracy", COLUMNS, rows, results, settings).publish(write=arguments.write)


if __name__ == "__main__":
    main()
