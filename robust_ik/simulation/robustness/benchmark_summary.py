"""What the runs of a method come to: four numbers with their confidence intervals, a price, and the Pareto front."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors import InputError
from robust_ik.simulation.robustness.benchmark_scenario import KINDS
from robust_ik.simulation.robustness.pareto_front import better, dominated_by
from robust_ik.simulation.robustness.run_metrics import RunScore

OBJECTIVES = ("kept", "speed", "leave", "chatter")
"""Numbers that the Pareto front is about: error in kept directions, peak speed over limit, time to leave, chatter."""
CAPS = {"kept": 1.0, "speed": 10.0}
"""What one run counts at most, so that one arm that is thrown about does not decide: rad scaled, limits."""
PRICES = {"kept": 0.02, "speed": 1.0, "leave": 1.0, "chatter": 2.0}
"""What costs 1: a kept error of 0.02, a peak at the speed limit, a second to leave, two changes of sign a second."""
SHOWN = ("kept", "lost", "final", "leave", "left", "speed", "chatter", "violations", "failed", "rest", "cost")
"""Numbers that are averaged for tables."""
RESAMPLES, LEVEL = 1000, 0.95
"""Resamples of the bootstrap, and the confidence level of intervals."""


@dataclass(frozen=True)
class RunKey:
    """Which run a score is of: its robot, the class of its scenario, and the scenario's name."""

    robot: str
    kind: str
    name: str


Scores = Mapping[RunKey, RunScore]
"""The runs of one method."""


@dataclass(frozen=True)
class MethodSummary:
    """A row of the table.

    Attributes:
        name: The method.
        means: Of each number of SHOWN: the mean over robots of the mean over classes of the mean over runs.
        intervals: Of each objective and of "price", the 95 % interval.
        price: The mean of the objectives, each divided by its entry in PRICES. Rows are ranked by it.
        beaten_by: Methods that are no worse in any objective and better in one; () on the Pareto front.
        front_share: Share of the resamples in which it is on the front.
    """

    name: str
    means: Mapping[str, float]
    intervals: Mapping[str, tuple[float, float]]
    price: float
    beaten_by: tuple[str, ...]
    front_share: float

    @property
    def on_front(self) -> bool:
        """Whether no other method is no worse in all objectives and better in one."""
        return not self.beaten_by


def summaries(scores: Mapping[str, Scores], *, seed: int = 0) -> list[MethodSummary]:
    """A row for each method, the lowest price first.

    Intervals come from resampling robots, and within a robot the scenarios of each class, the same for all methods.

    Args:
        scores: By method; all must have run the same scenarios.
        seed: Of the resampling.

    Raises:
        InputError: A method has not run what others have.
    """
    keys = sorted({key for each in scores.values() for key in each}, key=repr)
    for name, each in scores.items():
        if missing := [key for key in keys if key not in each]:
            raise InputError(f"{name} has not run {len(missing)} of {len(keys)} scenarios, such as {missing[0].name!r}")
    names = list(scores)
    table = {
        number: np.array([[getattr(scores[name][key], number) for key in keys] for name in names]) for number in SHOWN
    }
    for number, cap in CAPS.items():
        table[number] = np.minimum(table[number], cap)
    means = {number: _weighted(values, _weights(keys, None)[None])[:, 0] for number, values in table.items()}
    rng = np.random.default_rng(seed)
    draws = np.array([_weights(keys, rng) for _ in range(RESAMPLES)])
    drawn = np.stack([_weighted(table[number], draws) for number in OBJECTIVES], axis=-1)  # (M, B, 4)
    asked = [k for k, number in enumerate(OBJECTIVES) if not np.isnan(means[number]).all()]
    beaten = dominated_by({name: [means[OBJECTIVES[k]][i] for k in asked] for i, name in enumerate(names)})
    told = [k for k in range(RESAMPLES) if not np.isnan(drawn[:, k][:, asked]).any()]
    fronts = 1 - better(np.swapaxes(drawn, 0, 1)[told][..., asked]).max(axis=1, initial=False)  # (B, M)
    prices = np.nanmean(drawn / np.array([PRICES[number] for number in OBJECTIVES]), axis=-1)
    rows = []
    for i, name in enumerate(names):
        own = {number: float(means[number][i]) for number in SHOWN}
        spread = {number: _interval(drawn[i, :, k]) for k, number in enumerate(OBJECTIVES) if k in asked}
        spread["price"] = _interval(prices[i])
        share = float(fronts[:, i].mean()) if len(told) else float("nan")
        rows.append(MethodSummary(name, own, spread, price(own), beaten[name], share))
    return sorted(rows, key=lambda row: row.price)


def price(means: Mapping[str, float]) -> float:
    """The mean of the objectives, each in its price; those that no scenario asks for are left out."""
    parts = [means[number] / PRICES[number] for number in OBJECTIVES]
    return float(np.mean([each for each in parts if each == each]))


def means_of(scores: Scores) -> dict[str, float]:
    """The objectives of one method alone, as in `summaries`."""
    keys, weights = list(scores), _weights(list(scores), None)[None]
    found = {}
    for number in OBJECTIVES:
        values = np.array([[min(getattr(scores[key], number), CAPS.get(number, np.inf)) for key in keys]])
        found[number] = float(_weighted(values, weights)[0, 0])
    return found


def by_class(scores: Scores, number: str) -> dict[str, float]:
    """The mean of a number for each class of scenarios: over robots of the mean over runs; nan where none has it."""
    found = {}
    for kind in KINDS:
        some = {key: each for key, each in scores.items() if key.kind == kind}
        if some:
            values = np.array([[min(getattr(each, number), CAPS.get(number, np.inf)) for each in some.values()]])
            found[kind] = float(_weighted(values, _weights(list(some), None)[None])[0, 0])
    return found


def _weights(keys: Sequence[RunKey], rng: np.random.Generator | None) -> Array:
    """The weight of each run, (R,): each robot, and each class of a robot, counts the same; resampled with an rng."""
    robots: dict[str, dict[str, list[int]]] = {}
    for place, key in enumerate(keys):
        robots.setdefault(key.robot, {}).setdefault(key.kind, []).append(place)
    names = list(robots)
    chosen = names if rng is None else [names[i] for i in rng.integers(len(names), size=len(names))]
    weights = np.zeros(len(keys))
    for name in chosen:
        for places in robots[name].values():
            drawn = places if rng is None else [places[i] for i in rng.integers(len(places), size=len(places))]
            np.add.at(weights, drawn, 1 / (len(chosen) * len(robots[name]) * len(drawn)))
    return weights


def _weighted(values: Array, weights: Array) -> Array:
    """Means of numbers of runs, (M, R), by weights, (B, R): (M, B). What is nan, for no run or for all, is left out."""
    there = ~np.isnan(values).all(axis=0)
    if not there.any():
        return np.full((len(values), len(weights)), np.nan)
    total = weights[:, there].sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(values[:, there] @ weights[:, there].T / np.where(total > 0, total, np.nan))


def _interval(values: Array) -> tuple[float, float]:
    low, high = np.nanquantile(values, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return float(low), float(high)
