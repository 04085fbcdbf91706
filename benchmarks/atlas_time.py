"""Times the atlas of an arm: all coranks, default settings, after everything compiled is there.

`python -m benchmarks.atlas_time` prints the table for arms of six, seven and ten joints; with `--write` it goes into
docs/benchmarks.md, JSON beside it. A process of its own each time, one thread: CPU time of the first search, which
compiles or reads what is compiled, and of the second.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence

import numpy as np

from benchmarks.environments import UnavailableError, call, progress
from benchmarks.report import Report, options
from benchmarks.rounds import spread

ROBOTS = ("pa10", "panda", "ur5", "kinova_gen3", "srs_10r")
COLUMNS = (
    "robot",
    "rows / pieces by corank",
    "unexplained",
    "first search, CPU [s]",
    "CPU [s]",
    "q1 to q3",
    "wall [s]",
)
PROGRAM = """
import json, sys, time
import robust_ik as rik
robot = rik.load(sys.argv[1])
if hasattr(rik, "warmup"):
    rik.warmup()
def search():
    cpu, wall = time.process_time(), time.perf_counter()
    atlas = rik.find_singularities(robot)
    return atlas, time.process_time() - cpu, time.perf_counter() - wall
first = search() if sys.argv[2] == "twice" else None
atlas, cpu, wall = search()
print(json.dumps({
    "first": first[1] if first else None, "cpu": cpu, "wall": wall,
    "rows": [[corank, len(atlas.of_corank(corank)), sum(row.components for row in atlas.of_corank(corank))]
             for corank in range(1, atlas.highest + 1)],
    "unexplained": sum(each.unexplained for each in atlas.evidence),
}))
"""


def measure(name: str, rounds: int, twice: str) -> list[dict]:
    """One search a round, each in a process of its own."""
    found = []
    for number in range(rounds):
        progress.print(f"{name}: round {number + 1} of {rounds}")
        found.append(json.loads(call([sys.executable, "-c", PROGRAM, name, twice]).splitlines()[-1]))
    return found


def row(name: str, found: Sequence[dict]) -> Sequence[str]:
    """A line of the table."""
    low, middle, high = spread(np.array([each["cpu"] for each in found])).values()
    firsts = [each["first"] for each in found if each["first"] is not None]
    counts = ", ".join(f"{rows} / {pieces}" for _, rows, pieces in found[0]["rows"])
    first = f"{np.median(firsts):.2f}" if firsts else "–"
    wall = np.median([each["wall"] for each in found])
    unexplained = str(found[0]["unexplained"])
    return name, counts, unexplained, first, f"{middle:.2f}", f"{low:.2f} to {high:.2f}", f"{wall:.2f}"


def main() -> None:
    parser = options(__doc__)
    parser.set_defaults(rounds=3)
    parser.add_argument("--robots", nargs="*", default=ROBOTS)
    parser.add_argument("--once", action="store_true", help="no first search to warm up with")
    arguments = parser.parse_args()
    rows, results = [], {}
    for name in arguments.robots:
        try:
            results[name] = measure(name, arguments.rounds, "once" if arguments.once else "twice")
            rows.append(row(name, results[name]))
        except UnavailableError as error:
            results[name] = {"failure": str(error)}
            rows.append((name, str(error), *("–",) * 5))
    settings = {"rounds": arguments.rounds, "once": arguments.once}
    Report("atlas_time", COLUMNS, rows, results, settings).publish(write=arguments.write)


if __name__ == "__main__":
    main()
