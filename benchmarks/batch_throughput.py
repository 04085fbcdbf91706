"""Times work on many configurations at once, in µs for each: kinematics, steps, singular values; one core and all.

`python -m benchmarks.batch_throughput` prints the table; with `--write` it goes into docs/benchmarks.md, JSON and
figure beside it. The baseline is Pinocchio's Jacobian and `np.linalg.solve`, one by one. Ratios are of CPU time, the
speed-up by several cores of wall time. "One by one" compares a batch with its own function of one configuration, and
our function of one Jacobian with Pinocchio's call, what the harness adds included in both.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

import robust_ik as rik
from benchmarks import figures
from benchmarks.report import Report, options
from benchmarks.rounds import Contender, Round, Series, batches, calls, interleave, needed, ours
from benchmarks.step_latency import BASELINE, damped, pinocchio_step, stepper
from benchmarks.works import arm, twists

CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
FEW = 2000
"""How many of the configurations those get that are done one by one."""
AT_LEAST = 2000
"""A round is repeated for so many configurations, and three times."""
COLUMNS = (
    "what", "CPU [µs]", "wall [µs]", "ratio to Pinocchio + NumPy", "ratio to one by one, or to NumPy",
    "speed-up by cores",
)  # fmt: skip
KINEMATICS = ("pose", "jacobian", "hessian")
INVERSES: dict[str, rik.RobustInverse] = {"DLS": rik.DampedLeastSquares(), "SVD + JParse": rik.JParse()}


def stepping(robot: rik.Robot, inverse: rik.RobustInverse, q: np.ndarray, v: np.ndarray, threads: int) -> Round:
    """The round of a batch of our steps."""
    steps = needed(needed(rik, "Stepper")(robot, inverse), "steps")
    out = np.empty((len(q), robot.n))
    return batches(lambda: steps(q, v, out=out, threads=threads), len(q), repeats(q))


def repeats(q: np.ndarray) -> int:
    """How often a batch is done in a round."""
    return max(3, AT_LEAST // len(q))


def together(function: Callable[[np.ndarray], Any], q: np.ndarray) -> Round:
    """The round of a function of all configurations."""
    return batches(lambda: function(q), len(q), repeats(q))


def alone(function: Callable[[np.ndarray], Any], few: tuple[np.ndarray, np.ndarray]) -> Round:
    """The round of a function of one configuration."""
    return calls(lambda q, _: function(q), *few)


def contenders(robot: rik.Robot, q: np.ndarray, v: np.ndarray) -> list[Contender]:
    """Everyone."""
    few = (q[:FEW], v[:FEW])
    found = [ours(BASELINE, lambda: calls(pinocchio_step(robot, damped), *few))]
    for name, inverse in INVERSES.items():
        found.append(ours(f"robust_ik {name}, one by one", partial(stepper, robot, inverse, few)))
        found.append(ours(f"robust_ik {name}, batch", partial(stepping, robot, inverse, q, v, 1)))
        found.append(ours(f"robust_ik {name}, {CORES} threads", partial(stepping, robot, inverse, q, v, CORES)))
    jacobian = pinocchio_step(robot, lambda J, _: J)
    found.append(ours("Pinocchio's Jacobian, one by one", lambda: calls(jacobian, *few)))
    for name in KINEMATICS:
        function = getattr(robot, name)
        found.append(ours(f"robust_ik {name}, one by one", partial(alone, function, few)))
        found.append(ours(f"robust_ik {name}, batch", partial(together, function, q[: len(q) // 4])))
    J = robot.jacobian(q[:FEW])
    found.append(ours("np.linalg.svd, batch", partial(together, partial(np.linalg.svd, full_matrices=False), J)))
    found.append(ours("robust_ik svd, batch", partial(together, rik.svd, J)))
    return found


def pairs(series: dict[str, Series]) -> dict[str, dict[str, str]]:
    """The ratios that are between rows of one kind."""
    found: dict[str, dict[str, str]] = {name: {} for name in series}
    for name in INVERSES:
        single, batch, threads = (
            series[f"robust_ik {name}, {how}"] for how in ("one by one", "batch", f"{CORES} threads")
        )
        found[batch.name]["one"] = batch.ratio(single)
        found[threads.name]["cores"] = batch.ratio(threads, wall=True)
    for name in KINEMATICS:
        single, batch = series[f"robust_ik {name}, one by one"], series[f"robust_ik {name}, batch"]
        found[batch.name]["one"] = batch.ratio(single)
    single = series["robust_ik jacobian, one by one"]
    found[single.name]["one"] = single.ratio(series["Pinocchio's Jacobian, one by one"])
    found["robust_ik svd, batch"]["one"] = series["robust_ik svd, batch"].ratio(series["np.linalg.svd, batch"])
    return found


def row(each: Series, base: Series, pair: dict[str, str]) -> Sequence[str]:
    """A line of the table."""
    if each.failure:
        return each.name, *("–",) * 4, each.failure
    times = (f"{np.median(values):.3g}" for values in (each.cpu, each.wall))
    return each.name, *times, each.ratio(base), pair.get("one", "–"), pair.get("cores", "–")


def main() -> None:
    parser = options(__doc__)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--count", type=int, default=100_000)
    arguments = parser.parse_args()
    robot, _ = arm(arguments.robot)
    series = interleave(contenders(robot, *twists(robot, arguments.count)), arguments.rounds)
    compared, base = pairs(series), series[BASELINE]
    bars = {name: each.summary()["wall_us"] for name, each in series.items() if each.samples}
    Report(
        "batch_throughput",
        COLUMNS,
        [row(each, base, compared[name]) for name, each in series.items()],
        {name: {**each.summary([base]), "pairs": compared[name]} for name, each in series.items()},
        {"robot": arguments.robot, "count": arguments.count, "one by one": FEW, "rounds": arguments.rounds,
         "threads": CORES},
        text_last=True,
        figure=lambda path: figures.bars(path, {"one of many": bars}, "µs each, median and quartiles"),
    ).publish(write=arguments.write)  # fmt: skip


if __name__ == "__main__":
    main()
