"""Contenders that take turns: what they need, and the ratios between them, each within one round."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.environments import Peer, UnavailableError, progress
from benchmarks.peers.timing import WARM_UP, Sample, sample

Round = Callable[[], Sample]


@dataclass(frozen=True)
class Contender:
    """A row of a table.

    Attributes:
        name: What the row says.
        start: Makes ready, not measured, and gives the function of one round and the version, "" for our own; what has
            to be closed goes on the stack. Raises UnavailableError where it cannot be measured.
        what: A remark.
    """

    name: str
    start: Callable[[ExitStack], tuple[Round, str]]
    what: str = ""


def ours(name: str, build: Callable[[], Round], what: str = "") -> Contender:
    """A contender in this process."""
    return Contender(name, lambda _: (build(), ""), what)


def calls(step: Callable[..., Any], *columns: Iterable[Any]) -> Round:
    """The round of a function that is called once for every row; first, not measured, for a few."""
    kept = [list(column) for column in columns]
    for row in list(zip(*kept))[:WARM_UP]:
        step(*row)
    return lambda: sample(step, *kept)


def batches(run: Callable[[], Any], count: int, repeats: int = 1) -> Round:
    """The round of a function that does `count` things at once: times are per thing, spread is over the repeats."""
    run()  # what compiles or allocates does it now

    def round_() -> Sample:
        done = sample(lambda _: run(), range(repeats))
        return Sample(done.cpu_us / count, done.us / count, done.answers[-1])

    return round_


def peer(name: str, script: str, kind: str, work: Path, options: tuple[str, ...] = (), what: str = "") -> Contender:
    """A contender in a process of its own."""

    def start(stack: ExitStack) -> tuple[Round, str]:
        running = stack.enter_context(Peer(script, kind, work, options))
        return running.round, running.hello["version"]

    return Contender(name, start, what)


def needed(holder: object, name: str) -> Any:
    """An attribute of ours.

    Raises:
        UnavailableError: This version has none.
    """
    if not hasattr(holder, name):
        raise UnavailableError(f"this robust_ik has no {name}")
    return getattr(holder, name)


@dataclass
class Series:
    """What one contender did.

    Attributes:
        name: Whose.
        what: A remark.
        version: Of the system.
        samples: One a round; empty if it failed.
        failure: Why it has none.
    """

    name: str
    what: str = ""
    version: str = ""
    samples: list[Sample] = field(default_factory=list)
    failure: str = ""

    @property
    def cpu(self) -> np.ndarray:
        """CPU µs per call, one number a round."""
        return np.array([each.cpu_us for each in self.samples])

    @property
    def us(self) -> np.ndarray:
        """Wall µs of every call of all rounds."""
        return np.concatenate([each.us for each in self.samples])

    @property
    def answers(self) -> np.ndarray:
        """Of the last round."""
        return np.asarray(self.samples[-1].answers)

    @property
    def wall(self) -> np.ndarray:
        """Median wall µs per call, one number a round: for work on several cores."""
        return np.array([np.median(each.us) for each in self.samples])

    def ratios(self, base: Series, *, wall: bool = False) -> np.ndarray:
        """CPU time over that of another contender, round by round; or wall time."""
        return self.wall / base.wall if wall else self.cpu / base.cpu

    def ratio(self, base: Series, *, wall: bool = False) -> str:
        """The median of the ratios, for a table."""
        return f"{np.median(self.ratios(base, wall=wall)):.3g}" if self.samples and base.samples else "–"

    def summary(self, bases: Sequence[Series] = ()) -> dict[str, Any]:
        """What is saved of it."""
        if self.failure:
            return {"version": self.version, "failure": self.failure}
        tails = dict(zip(("p99", "p99.9", "max"), np.percentile(self.us, (99, 99.9, 100)).tolist()))
        return {
            "version": self.version,
            "what": self.what,
            "cpu_us": spread(self.cpu),
            "cpu_us_of_rounds": self.cpu.tolist(),
            "wall_us": {**spread(self.us), "mean": float(self.us.mean()), **tails},
            "calls_per_round": len(self.samples[-1].us),
            "ratio": {base.name: spread(self.ratios(base)) for base in bases if base.samples},
        }


def spread(values: np.ndarray) -> dict[str, float]:
    """Median and quartiles."""
    return dict(zip(("q1", "median", "q3"), np.percentile(values, (25, 50, 75)).tolist()))


def interleave(contenders: Sequence[Contender], rounds: int) -> dict[str, Series]:
    """All contenders, then all again: A B A B. One that fails drops out with its reason."""
    series = {each.name: Series(each.name, each.what) for each in contenders}
    with ExitStack() as stack:
        ready: dict[str, Round] = {}
        for each in contenders:
            try:
                ready[each.name], series[each.name].version = each.start(stack)
            except UnavailableError as error:
                _drop(series[each.name], error)
        for number in range(rounds):
            progress.print(f"round {number + 1} of {rounds}: {len(ready)} contenders")
            for name in tuple(ready):
                try:
                    series[name].samples.append(ready[name]())
                except UnavailableError as error:
                    del ready[name]
                    _drop(series[name], error)
    return series


def _drop(series: Series, error: UnavailableError) -> None:
    progress.print(f"without {series.name}: {error}")
    series.samples.clear()
    series.failure = str(error)
