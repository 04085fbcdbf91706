"""What the benchmark measured, as one value that is saved as JSON: all tables, figures and pages are made from it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robust_ik.errors import LoadError
from robust_ik.robot.robot import Robot
from robust_ik.runtime.files import read_file
from robust_ik.runtime.output_files import write_file
from robust_ik.runtime.progress import ProgressCallback
from robust_ik.simulation.robustness.benchmark_methods import BenchmarkMethod
from robust_ik.simulation.robustness.benchmark_scenario import RobustnessScenario
from robust_ik.simulation.robustness.benchmark_summary import MethodSummary, RunKey, summaries
from robust_ik.simulation.robustness.lockstep_runs import run_scenarios
from robust_ik.simulation.robustness.run_metrics import RunScore, score

FORMAT, LARGEST = 1, 2**30
"""Version of the file, and how many bytes of one are read at most."""
TOLD = ("exit", "place", "dt", "drive", "noise", "leavable", "shown")
"""What is saved of a scenario beside its key; its seconds too."""


@dataclass(frozen=True, eq=False)
class BenchmarkResults:
    """Scores of methods on scenarios.

    Attributes:
        scenarios: What there is to know of each, by its key.
        scores: The runs of each method, by its name.
    """

    scenarios: Mapping[RunKey, Mapping[str, Any]]
    scores: Mapping[str, Mapping[RunKey, RunScore]]

    def summaries(self, *, seed: int = 0) -> list[MethodSummary]:
        """A row for each method, the lowest price first."""
        return summaries(self.scores, seed=seed)

    def joined(self, other: BenchmarkResults) -> BenchmarkResults:
        """Both: robots or methods that this one has not are added."""
        names = dict.fromkeys([*self.scores, *other.scores])
        scores = {name: {**self.scores.get(name, {}), **other.scores.get(name, {})} for name in names}
        return BenchmarkResults({**self.scenarios, **other.scenarios}, scores)

    def save(self, path: str | Path) -> Path:
        """Writes it as JSON."""
        keys = list(self.scenarios)
        places = {key: place for place, key in enumerate(keys)}
        data = {
            "format": FORMAT,
            "scenarios": [{**vars(key), **self.scenarios[key]} for key in keys],
            "methods": {
                name: [[places[key], found.to_json()] for key, found in runs.items()]
                for name, runs in self.scores.items()
            },
        }
        return write_file(path, json.dumps(data, allow_nan=False) + "\n")

    @classmethod
    def load(cls, path: str | Path) -> BenchmarkResults:
        """What `save` wrote.

        Raises:
            LoadError: The file holds something else.
        """
        try:
            data = json.loads(read_file(path, LARGEST)[1])
            if data["format"] != FORMAT:
                raise LoadError(f"{path}: this version reads format {FORMAT}, got {data['format']!r}")
            told = [dict(each) for each in data["scenarios"]]
            keys = [RunKey(each.pop("robot"), each.pop("kind"), each.pop("name")) for each in told]
            scores = {
                name: {keys[place]: RunScore.from_json(found) for place, found in runs}
                for name, runs in data["methods"].items()
            }
            return cls(dict(zip(keys, told)), scores)
        except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
            raise LoadError(f"{path}: these are no results of the benchmark: {error!r}") from error


def measure(
    robots: Sequence[tuple[Robot, Sequence[RobustnessScenario]]],
    methods: Mapping[str, BenchmarkMethod],
    progress: ProgressCallback,
) -> BenchmarkResults:
    """Runs every method on the scenarios of every robot.

    Args:
        robots: Each with its scenarios.
        methods: By name.
        progress: Called with (methods done, methods in all), each robot counted anew.
    """
    total, done = len(robots) * len(methods), 0
    scores: dict[str, dict[RunKey, RunScore]] = {name: {} for name in methods}
    told: dict[RunKey, dict[str, Any]] = {}
    for robot, scenarios in robots:
        told |= facts(scenarios)
        for name, method in methods.items():
            scores[name] |= scored(robot, scenarios, method)
            done += 1
            progress(done, total)
    return BenchmarkResults(told, scores)


def scored(robot: Robot, scenarios: Sequence[RobustnessScenario], method: BenchmarkMethod) -> dict[RunKey, RunScore]:
    """The scores of a method on scenarios of one robot."""
    traces = run_scenarios(robot, scenarios, method)
    return {key_of(each): score(robot, each, trace) for each, trace in zip(scenarios, traces)}


def key_of(scenario: RobustnessScenario) -> RunKey:
    """The key of a scenario's runs."""
    return RunKey(scenario.robot, scenario.kind, scenario.name)


def facts(scenarios: Sequence[RobustnessScenario]) -> dict[RunKey, dict[str, Any]]:
    """What is saved of scenarios, by key."""
    return {
        key_of(each): {name: getattr(each, name) for name in TOLD} | {"seconds": each.dt * each.steps}
        for each in scenarios
    }
