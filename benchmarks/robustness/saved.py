"""The runs behind the page, kept beside it: a row is added without measuring the others anew."""

from __future__ import annotations

import gzip
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from benchmarks.report import OUT
from benchmarks.robustness.contenders import TUNED, Contender
from benchmarks.tables import DOCS
from robust_ik.simulation.robustness import BenchmarkResults, RunScore

FOLDER = DOCS / "benchmarks"
RUNS, RECORD = "robustness_runs.json.gz", "robustness.json"
DIGITS = 6
"""Of the numbers of a run. Chosen: what is kept and what is measured say the same; fewer would let rows tie."""

Found = tuple[BenchmarkResults, dict[str, str], dict[str, Contender]]
"""Results of all rows, why contenders have none, and the tuned ones, by name: what `halves.measure` gives."""


def rounded(results: BenchmarkResults) -> BenchmarkResults:
    """The results with numbers as they are kept."""
    return BenchmarkResults(
        results.scenarios,
        {name: {key: _rounded(each) for key, each in runs.items()} for name, runs in results.scores.items()},
    )


def _rounded(score: RunScore) -> RunScore:
    told = score.to_json()
    return RunScore.from_json(
        {name: float(f"{each:.{DIGITS}g}") if isinstance(each, float) else each for name, each in told.items()}
    )


def save(results: BenchmarkResults, folder: Path) -> Path:
    """Writes all runs without their curves into a folder, packed."""
    bare = {name: {key: replace(each, curves=()) for key, each in of.items()} for name, of in results.scores.items()}
    plain = BenchmarkResults(results.scenarios, bare).save(_unpacked())
    path = folder / RUNS
    path.write_bytes(gzip.compress(plain.read_bytes(), mtime=0))
    return path


def load(folder: Path) -> Found:
    """What the page tells of: its runs, and what was said of contenders."""
    plain = _unpacked()
    plain.write_bytes(gzip.decompress((folder / RUNS).read_bytes()))
    told = json.loads((folder / RECORD).read_text(encoding="utf-8"))
    chosen = {name: Contender(name).set_to(parameters) for name, parameters in told["tuned"].items()}
    return BenchmarkResults.load(plain), dict(told["failures"]), chosen


def _unpacked() -> Path:
    OUT.mkdir(parents=True, exist_ok=True)
    return OUT / RUNS.removesuffix(".gz")


def added(before: Found, now: Found, measured: Sequence[Contender], everyone: Sequence[Contender]) -> Found:
    """What is kept, with all that is told of some contenders replaced by what has been measured now.

    Args:
        before: What is kept.
        now: What has been measured.
        measured: The contenders of `now`, those without a row too.
        everyone: All that there are, in their order: what is kept of others is dropped.

    Raises:
        ValueError: The scenarios are not those that the kept rows have run.
    """
    if before[0].scenarios != now[0].scenarios:
        raise ValueError("the kept rows have run other scenarios: measure all contenders anew, without --add")
    names = [each.name for each in everyone]
    again = {each.name for each in measured}
    runs = _merged(before[0].scores, now[0].scores, again, [*names, *(name + TUNED for name in names)])
    failures, chosen = _merged(before[1], now[1], again, names), _merged(before[2], now[2], again, names)
    return BenchmarkResults(now[0].scenarios, runs), failures, chosen


Told = TypeVar("Told")


def _merged(
    before: Mapping[str, Told], now: Mapping[str, Told], again: set[str], order: Sequence[str]
) -> dict[str, Told]:
    """What is said of contenders by name or label, in an order: now of those measured again, before of the others."""
    found = {**{name: value for name, value in before.items() if name.removesuffix(TUNED) not in again}, **now}
    return {name: found[name] for name in order if name in found}
