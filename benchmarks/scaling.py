"""Times a step against the number of joints, 2 to 14, and against the size of a batch, 1 to 100,000.

`python -m benchmarks.scaling` prints the table; with `--write` it goes into docs/benchmarks.md, JSON and figure beside
it. The arms are zigzags of links of 0.3 m; batches are of a Panda. CPU µs for each configuration.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from benchmarks import figures
from benchmarks.batch_throughput import FEW, INVERSES, stepping
from benchmarks.chains import Chain
from benchmarks.report import Report, options
from benchmarks.rounds import Series, calls, interleave, ours
from benchmarks.step_latency import BASELINE, damped, pinocchio_step, stepper
from benchmarks.works import arm, bare, twists

JOINTS = (2, 3, 4, 6, 7, 10, 14)
BATCHES = (1, 10, 100, 1000, 10_000, 100_000)
COLUMNS = ("varied", "size", "system", "CPU [µs]", "q1 to q3", "ratio to Pinocchio + NumPy")
Measured = dict[int, dict[str, Series]]


def against_joints(joints: Sequence[int], steps: int, rounds: int) -> Measured:
    """A step one by one, number of joints → system → series."""
    found = {}
    for n in joints:
        robot, _ = bare(Chain.zigzag(n))
        work = twists(robot, steps)
        everyone = [ours(BASELINE, partial(calls, pinocchio_step(robot, damped), *work))]
        everyone += [ours(f"robust_ik {name}", partial(stepper, robot, each, work)) for name, each in INVERSES.items()]
        found[n] = interleave(everyone, rounds)
    return found


def against_batch(sizes: Sequence[int], rounds: int) -> Measured:
    """A batch of steps, size → system → series."""
    robot, _ = arm("panda")
    q, v = twists(robot, max(FEW, *sizes))
    found = {}
    for size in sizes:
        everyone = [ours(BASELINE, partial(calls, pinocchio_step(robot, damped), q[:FEW], v[:FEW]))]
        for name, each in INVERSES.items():
            everyone.append(ours(f"robust_ik {name}", partial(stepping, robot, each, q[:size], v[:size], 1)))
        found[size] = interleave(everyone, rounds)
    return found


def rows(varied: str, measured: Measured) -> list[Sequence[str]]:
    """Lines of the table; a reason for what failed is given once."""
    lines: list[Sequence[str]] = []
    told: set[str] = set()
    for size, series in measured.items():
        for each in series.values():
            if each.samples:
                low, middle, high = np.percentile(each.cpu, (25, 50, 75))
                ratio = each.ratio(series[BASELINE])
                lines.append((varied, str(size), each.name, f"{middle:.3g}", f"{low:.3g} to {high:.3g}", ratio))
            elif each.name + each.failure not in told:
                told.add(each.name + each.failure)
                lines.append((varied, str(size), each.name, "–", "–", each.failure))
    return lines


def curves(measured: Measured) -> dict[str, list[tuple[float, float]]]:
    """What the figure shows: system → (size, CPU µs)."""
    found: dict[str, list[tuple[float, float]]] = {}
    for size, series in measured.items():
        for name, each in series.items():
            if each.samples:
                found.setdefault(name, []).append((size, float(np.median(each.cpu))))
    return found


def saved(measured: Measured) -> dict[str, Any]:
    """For JSON."""
    return {
        str(size): {name: each.summary([series[BASELINE]]) for name, each in series.items()}
        for size, series in measured.items()
    }


def main() -> None:
    parser = options(__doc__)
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--joints", type=int, nargs="*", default=JOINTS)
    parser.add_argument("--batches", type=int, nargs="*", default=BATCHES)
    arguments = parser.parse_args()
    kinds = {
        "joints": against_joints(arguments.joints, arguments.steps, arguments.rounds),
        "batch size": against_batch(arguments.batches, arguments.rounds),
    }
    panels = {varied: curves(measured) for varied, measured in kinds.items()}
    Report(
        "scaling",
        COLUMNS,
        [line for varied, measured in kinds.items() for line in rows(varied, measured)],
        {varied: saved(measured) for varied, measured in kinds.items()},
        {"steps": arguments.steps, "rounds": arguments.rounds},
        text_last=True,
        figure=lambda path: figures.lines(path, panels, "CPU µs each"),
    ).publish(write=arguments.write)


if __name__ == "__main__":
    main()
