"""Runs everybody in closed loop within joint limits, from random starts to random poses on twelve arms.

`python -m benchmarks.closed_loop` gives every peer an environment of its own below out/peers, from the versions pinned
in benchmarks/peers, and prints tables: who gets there, who is stuck, who chatters. With `--write` they go into
docs/closed_loop.md, and JSON and a figure into docs/benchmarks. All get the same URDF, starts and targets. What has
been measured is kept in out/closed_loop, and taken from there where runs, scripts and packages are still the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import track

import robust_ik as rik
from benchmarks import figures
from benchmarks.environments import UnavailableError, interpreter
from benchmarks.loop_contenders import OURS, PEERS, Answer, Contender, answer, default_method
from benchmarks.loop_runs import ARMS, DT, bare, everyday, poses, random_runs
from benchmarks.loop_verdicts import Row, Run, limits_kept, short, sign_changes, summary, words
from benchmarks.peers.loops import Loop
from benchmarks.report import Report
from benchmarks.tables import markdown, parser, publish

PAGE, NAME = "closed_loop.md", "closed_loop"
COLUMNS = (
    "system", "reached", "stuck", "still moving", "chattering", "… at [rad/s]", "error [mm]: median", "p90",
    "error [°]: median", "p90", "limits kept",
)  # fmt: skip
EVERYDAY = (
    "robust_ik", "error [mm]", "last second: largest speed [rad/s]", "… sign changes", "nearest links [mm]", "it",
)  # fmt: skip


def measure(contenders: Sequence[Contender], loops: Mapping[str, Loop], jobs: int = 1) -> list[Row]:
    """All runs of all contenders."""
    found: dict[Contender, dict[str, Answer]] = {each: {} for each in contenders}
    everything = [(arm, each) for arm in loops for each in contenders]
    for script in dict.fromkeys(each.script for each in contenders):
        with suppress(UnavailableError):  # told by each answer
            interpreter(script)
    with ThreadPoolExecutor(jobs) as pool:  # of threads that wait for processes
        made = pool.map(lambda task: answer(task[1], loops[task[0]], task[0]), everything)
        bar = track(made, total=len(everything), console=Console(stderr=True), description="running")
        for (arm, each), given in zip(everything, bar):
            found[each][arm] = given
    places = {arm: judge_of(arm) for arm in loops}
    default, rows = default_method(), []
    for each, by_arm in found.items():
        version = max(made.version for made in by_arm.values())
        mark = ", the default" if each.script == "robust_ik" and each.options[1] == default else ""
        runs = {arm: judged(arm, loops[arm], places[arm], made) for arm, made in by_arm.items() if made.runs}
        failures = {arm: made.failure for arm, made in by_arm.items() if made.failure}
        rows.append(Row(each.name + mark, version, each.script == "robust_ik", runs, failures))
    return rows


Place = Callable[[np.ndarray], np.ndarray]
"""From configurations, (N, n), to where the tools are, (N, k, 4, 4): judges all alike."""


def judge_of(arm: str) -> Place:
    robot, made, _ = bare(arm)
    return lambda q: poses(robot, tuple(chain.tip for chain in made), q)


def judged(arm: str, loop: Loop, place: Place, made: Answer) -> list[Run]:
    """What is said of a contender's runs."""
    ends = place(np.array([each["q"] for each in made.runs]))
    return [Run.of(arm, pair, loop, *each) for pair, each in enumerate(zip(ends, made.runs))]


def table_row(row: Row) -> tuple[str, ...]:
    """Of all arms together."""
    if not row.all:
        return (row.name, *("–",) * (len(COLUMNS) - 1))
    found = summary(row.all)
    shares = (f"{found[name] / found['runs']:.0%}" for name in ("reached", "stuck", "moving", "chatters"))
    fastest = short(found["fastest_rad_s"]) if found["chatters"] else "–"
    errors = [short(1e3 * found["position_m"][which]) for which in ("median", "p90")]
    errors += [short(np.degrees(found["rotation_rad"][which])) for which in ("median", "p90")]
    return (f"{row.name} {row.version}", *shares, fastest, *errors, limits_kept(found))


def arm_tables(rows: Sequence[Row], arms: Sequence[str]) -> tuple[str, str]:
    """Counts, and errors in mm, of every system on every arm."""
    counts, errors = [], []
    for row in rows:
        found = {arm: summary(runs) for arm, runs in row.runs.items()}
        cells = {arm: f"{each['reached']} / {each['stuck']} / {bold(each['chatters'])}" for arm, each in found.items()}
        counts.append((row.name, *(cells.get(arm, "–") for arm in arms)))
        parts = {
            arm: " / ".join(short(1e3 * each["position_m"][which]) for which in ("median", "p90"))
            for arm, each in found.items()
        }
        errors.append((row.name, *(parts.get(arm, "–") for arm in arms)))
    columns = ("system", *arms)
    return markdown(columns, counts), markdown(columns, errors)


def bold(count: int) -> str:
    """A number that should be 0."""
    return f"**{count}**" if count else "0"


def everyday_rows(contenders: Sequence[Contender], seconds: float) -> list[tuple[str, ...]]:
    """The everyday case: a row for each of ours."""
    loop, robot = everyday(seconds), rik.load("panda")
    near, rows = rik.CollisionLimit.of(robot), []
    for each in contenders:
        made = answer(replace(each, options=(*each.options, "--collisions", "yes")), loop, "everyday")
        if made.failure:
            rows.append((each.name, *("–",) * (len(EVERYDAY) - 2), made.failure))
            continue
        (run,) = judged("panda", loop, lambda q: poses(robot, loop.tips, q), made)
        closest = min(pair.distance for pair in near.distances(robot, run.q))
        rows.append((
            each.name, short(1e3 * run.error[0]), short(np.abs(run.tail).max()), str(sign_changes(run.tail).max()),
            short(1e3 * closest), run.word,
        ))  # fmt: skip
    return rows


def draw(path: Path, rows: Sequence[Row], loops: Mapping[str, Loop]) -> None:
    """The last second of a bad run of each system: of the joint that is worst there."""
    panels = {}
    for row in rows:
        if not row.all:
            continue
        run = row.worst(rows)
        loop = loops[run.arm]
        share = np.abs(run.tail).max(axis=0) / loop.speeds * np.where(run.shaking, 1e3, 1)
        joint = int(np.argmax(share))
        times = DT * (np.arange(len(run.tail)) - len(run.tail))
        panels[f"{row.name}\n{run.arm}, run {run.pair + 1}, {loop.joints[joint]}"] = (times, run.tail[:, joint])
    figures.series(path, panels, "time to the end of the run [s]", "joint velocity [rad/s]")


def results(rows: Sequence[Row]) -> dict[str, Any]:
    """For JSON."""
    return {
        row.name: {
            "version": row.version,
            "all": summary(row.all) if row.all else None,
            "arms": {arm: summary(runs) for arm, runs in row.runs.items()},
            "failures": row.failures,
        }
        for row in rows
    }


def main() -> None:
    options = parser(__doc__, PAGE)
    options.add_argument("--pairs", type=int, default=16, help="starts and targets for each arm")
    options.add_argument("--seconds", type=float, default=15.0, help="how long a run takes at the most")
    options.add_argument("--arms", nargs="+", choices=tuple(ARMS), default=tuple(ARMS), metavar="ARM")
    options.add_argument("--only", default="", help="systems whose names contain this")
    options.add_argument("--no-peers", action="store_true", help="only this package")
    options.add_argument("--jobs", type=int, default=1, help="systems that run at the same time")
    arguments = options.parse_args()
    ours = [each for each in OURS if arguments.only in each.name]
    peers = [each for each in PEERS if arguments.only in each.name and not arguments.no_peers]
    loops = {arm: random_runs(arm, arguments.pairs, arguments.seconds) for arm in arguments.arms}
    rows = measure([*ours, *peers], loops, arguments.jobs)
    everyday_table = everyday_rows(ours, arguments.seconds)
    settings = {"pairs": arguments.pairs, "seconds": arguments.seconds, "arms": list(arguments.arms)}
    report = Report(
        NAME, COLUMNS, [table_row(row) for row in rows], results(rows) | {"everyday": everyday_table}, settings,
        text_last=True, figure=lambda path: draw(path, rows, loops), page=PAGE,
    )  # fmt: skip
    report.publish(write=arguments.write)
    counts, errors = arm_tables(rows, arguments.arms)
    more = {
        "words": words(rows, settings), "arms": counts, "errors": errors,
        "everyday": markdown(EVERYDAY, everyday_table, text_last=True),
    }  # fmt: skip
    for mark, text in more.items():
        print()
        publish(text, PAGE, f"{NAME}_{mark}", write=arguments.write)


if __name__ == "__main__":
    main()
