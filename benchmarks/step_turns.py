"""Systems that take turns at the same control steps, and the time that each takes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.environments import Peer, UnavailableError, progress


@dataclass(frozen=True)
class Contender:
    """A row of a table.

    Attributes:
        name: What the row says.
        script: File in benchmarks/peers, without its ending `_step.py` or `_arms.py`; also the environment and its
            requirements.
        what: How it resolves priorities and limits.
        options: Of the script.
    """

    name: str
    script: str
    what: str
    options: tuple[str, ...] = ()


@dataclass
class Taken:
    """What one contender took.

    Attributes:
        times: CPU time of a step, µs, once a round.
        tails: The 99 % quantiles of the wall time, µs.
        version: Its version.
        failure: Why it is not measured; empty if it is.
    """

    times: list[float] = field(default_factory=list)
    tails: list[float] = field(default_factory=list)
    version: str = ""
    failure: str = ""

    def cells(self, first: Taken) -> list[str]:
        """The median time, the median of the ratios to the first one's times in the same rounds, and the tail."""
        ratio = "–" if first.failure else f"{np.median(np.divide(self.times, first.times)):.2g}"
        return [f"{np.median(self.times):.0f}", ratio, f"{np.median(self.tails):.0f}"]


def take_turns(
    contenders: Sequence[Contender],
    kind: str,
    file: Path,
    rounds: int,
    judge: Callable[[Contender, np.ndarray], None],
) -> dict[Contender, Taken]:
    """Lets each contender make the steps once a round.

    Args:
        contenders: The contenders.
        kind: The ending of their scripts.
        file: The work.
        rounds: Number of rounds.
        judge: Looks at the joint velocities of a contender's first round.
    """
    found = {contender: Taken() for contender in contenders}
    running: dict[Contender, Peer] = {}
    with ExitStack() as stack:
        for contender, taken in found.items():
            try:
                running[contender] = stack.enter_context(Peer(contender.script, kind, file, contender.options))
                taken.version = running[contender].hello["version"]
            except UnavailableError as error:
                taken.failure = str(error)
        for number in range(rounds):
            progress.print(f"round {number + 1} of {rounds}")
            for contender, taken in found.items():
                if taken.failure:
                    continue
                try:
                    done = running[contender].round()
                except UnavailableError as error:
                    taken.failure = str(error)
                    continue
                taken.times.append(done.cpu_us)
                taken.tails.append(float(np.quantile(done.us, 0.99)))
                if number == 0:
                    judge(contender, np.asarray(done.answers))
    return found


def rows_of(found: dict[Contender, Taken], judged: dict[Contender, list[str]], blanks: int) -> list[tuple[str, ...]]:
    """The rows of a table: name and version, times, what was judged, and what the contender does.

    Args:
        found: What each took; ratios are to the first.
        judged: Further cells of each.
        blanks: Number of cells that a contender without a measurement leaves empty.
    """
    first = next(iter(found.values()))
    return [
        (each.name, *("–",) * blanks, taken.failure)
        if taken.failure
        else (f"{each.name} {taken.version}", *taken.cells(first), *judged[each], each.what)
        for each, taken in found.items()
    ]
