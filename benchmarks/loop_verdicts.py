"""What a run in closed loop is said to have done: reached, stuck, still moving; and whether it chatters."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.peers.loops import Loop
from benchmarks.peers.timing import error

LAST = 0.5
"""Seconds at the end that are looked at."""
FAST, CHANGES = 0.01, 5
"""Chattering: a joint faster than this share of its speed limit that changes its sign so often."""
ZERO = 1e-6
"""rad/s that count as none: rounding has signs too."""
RESTING = 1e-3
"""rad/s; stuck: away from the target with all joints slower than this."""
THERE = (1e-3, 1e-2)
"""Reached: no tool is further from its target than this, m and rad."""
KEPT = 1e-9
"""rad and rad/s beyond a limit that count as none."""


def sign_changes(series: np.ndarray) -> np.ndarray:
    """How often each joint turns, stops or starts, (n,), in a series of joint velocities, (steps, n)."""
    signs = np.sign(np.where(np.abs(series) < ZERO, 0.0, series))
    return (np.diff(signs, axis=0) != 0).sum(axis=0)


def chattering(series: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """Which joints shake in a series of joint velocities, (n,).

    Args:
        series: rad/s, (steps, n), half a second of them.
        speeds: Speed limits, rad/s, (n,).
    """
    return (np.abs(series).max(axis=0) > FAST * speeds) & (sign_changes(series) >= CHANGES)


@dataclass(frozen=True, eq=False)
class Run:
    """One run and what is said of it.

    Attributes:
        arm: Which arm.
        pair: Which start and target of it.
        q: Where it ends, (n,).
        error: Of the worst tool, m and rad, (2,).
        tail: Joint velocities of the last second, (steps, n).
        shaking: Which joints chatter, (n,).
        fastest: Of the joints that chatter, rad/s; else 0.
        still: Whether it rests in the end.
        excess: Beyond limits, rad and rad/s, (2,).
        refused: Steps without an answer.
    """

    arm: str
    pair: int
    q: np.ndarray
    error: np.ndarray
    tail: np.ndarray
    shaking: np.ndarray
    fastest: float
    still: bool
    excess: np.ndarray
    refused: int

    @classmethod
    def of(cls, arm: str, pair: int, loop: Loop, poses: np.ndarray, answer: dict[str, Any]) -> Run:
        """What a script answered.

        Args:
            arm: Which arm.
            pair: Which of its runs.
            loop: All of its runs.
            poses: Where the tools end, (k, 4, 4).
            answer: As `peers.loops.driven` gives it.
        """
        tail = np.array(answer["tail"])
        end = tail[-round(LAST / loop.dt) :]
        shaking = chattering(end, loop.speeds)
        return cls(
            arm, pair, np.array(answer["q"]), error(poses, loop.targets[pair]).max(axis=0), tail, shaking,
            float(np.abs(end[:, shaking]).max(initial=0.0)), bool(np.abs(end).max() < RESTING),
            np.array(answer["excess"]), int(answer["refused"]),
        )  # fmt: skip

    @property
    def reached(self) -> bool:
        """Whether all tools are at their targets."""
        return bool((self.error < THERE).all())

    @property
    def stuck(self) -> bool:
        """Whether it rests elsewhere."""
        return self.still and not self.reached

    @property
    def chatters(self) -> bool:
        """Whether any joint does."""
        return bool(self.shaking.any())

    @property
    def moving(self) -> bool:
        """Whether it is neither there, nor at rest, nor chattering when its time is over."""
        return not (self.reached or self.still or self.chatters)

    @property
    def word(self) -> str:
        """What it did, in a few words."""
        if self.chatters:
            return "chatters at its target" if self.reached else "chatters"
        return "arrives" if self.reached else "rests short of it" if self.still else "is still moving"


@dataclass(frozen=True, eq=False)
class Row:
    """All runs of one system.

    Attributes:
        name: Who.
        version: Of its package.
        ours: Whether it is this package.
        runs: By arm.
        failures: By arm: why there are none.
    """

    name: str
    version: str
    ours: bool
    runs: dict[str, list[Run]]
    failures: dict[str, str]

    @property
    def all(self) -> list[Run]:
        """Of all arms."""
        return [run for runs in self.runs.values() for run in runs]

    def worst(self, rows: Sequence[Row]) -> Run:
        """The run that chatters fastest; where none does, the one that most others chatter in."""
        others = Counter((run.arm, run.pair) for row in rows for run in row.all if run.chatters)
        return max(self.all, key=lambda run: (run.fastest, others[run.arm, run.pair], not run.reached))


def summary(runs: Sequence[Run]) -> dict[str, Any]:
    """Counts, errors and broken limits of some runs."""
    errors = np.array([run.error for run in runs])
    middle, most = np.median(errors, axis=0), np.quantile(errors, 0.9, axis=0)
    excess = np.max([run.excess for run in runs], axis=0)
    return {
        "runs": len(runs),
        **{name: sum(getattr(run, name) for run in runs) for name in ("reached", "stuck", "chatters", "moving")},
        "fastest_rad_s": max(run.fastest for run in runs),
        "position_m": {"median": float(middle[0]), "p90": float(most[0])},
        "rotation_rad": {"median": float(middle[1]), "p90": float(most[1])},
        "excess": {"rad": float(excess[0]), "rad_s": float(excess[1])},
        "refused_steps": sum(run.refused for run in runs),
    }


def short(value: float) -> str:
    """Two digits of a number, "0" for next to nothing."""
    return "0" if value < 5e-4 else f"{value:.2g}" if value < 100 else f"{value:.0f}"


def limits_kept(found: dict[str, Any]) -> str:
    """In words, from a summary: yes, or to within what."""
    over = found["excess"]
    beyond = [f"{value:.0e} {unit}" for value, unit in ((over["rad"], "rad"), (over["rad_s"], "rad/s")) if value > KEPT]
    return f"to {', '.join(beyond)}" if beyond else "yes"


def words(rows: Sequence[Row], settings: dict[str, Any]) -> str:
    """What the tables say, in sentences."""
    found = [(row, summary(row.all)) for row in rows if row.all]
    count = f"{settings['pairs']} runs on each of {len(settings['arms'])} arms"
    lines = [f"{count}, {settings['seconds']:g} s each at the most."]
    calm = [row.name for row, each in found if not each["chatters"]]
    lines.append(f"Chatter in no run: {listed(calm)}.")
    ours, peers = ([pair for pair in found if pair[0].ours is mine] for mine in (True, False))
    still = [pair for pair in peers if pair[0].name in calm]
    groups = {"this package": ours, "the peers": peers}
    if len(still) < len(peers):
        groups["the peers that chatter in no run"] = still
    for who, group in groups.items():
        if group:
            lines += best(who, group)
    broken = [f"{row.name} ({limits_kept(each)[3:]})" for row, each in found if limits_kept(each) != "yes"]
    lines.append(f"Limits exceeded by more than {KEPT:g} rad or rad/s: by {listed(broken)}.")
    lines += [f"{row.name} did not run on {arm}: {why}." for row in rows for arm, why in row.failures.items()]
    return "\n".join(f"* {line}" for line in lines)


def best(who: str, group: Sequence[tuple[Row, dict[str, Any]]]) -> list[str]:
    """Who of a group gets furthest, and who chatters most."""
    row, each = max(group, key=lambda pair: pair[1]["reached"])
    nearest, least = min(group, key=lambda pair: pair[1]["position_m"]["median"])
    shaky, most = max(group, key=lambda pair: pair[1]["chatters"])
    lines = [
        f"Of {who} {row.name} reaches most targets, {each['reached']} of {each['runs']}; {nearest.name} ends nearest, "
        f"{short(1e3 * least['position_m']['median'])} mm in the median."
    ]
    if most["chatters"]:
        lines.append(
            f"Of {who} {shaky.name} chatters most, in {most['chatters']} of {most['runs']} runs, "
            f"at up to {short(most['fastest_rad_s'])} rad/s."
        )
    return lines


def listed(names: Sequence[str]) -> str:
    """Names in a sentence."""
    return "; ".join(names) if names else "none"
