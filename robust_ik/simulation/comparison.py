"""Runs scenarios with several methods each, for comparison."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError, listed
from robust_ik.runtime.parallel import run_pieces
from robust_ik.runtime.progress import ProgressCallback
from robust_ik.simulation.scenario import Method, Scenario
from robust_ik.simulation.simulator import simulate
from robust_ik.simulation.trajectory import Trajectory


@checked
def compare(
    scenarios: Scenario | Sequence[Scenario],
    methods: Mapping[str, Method] | None = None,
    *,
    executor: Executor | None = None,
    progress: ProgressCallback | None = None,
) -> dict[str, dict[str, Trajectory]]:
    """Runs every scenario with every method.

    Args:
        scenarios: One or several, with different names.
        methods: Inverses or resolvers by label; by default those of each scenario.
        executor: An executor for the runs, any `concurrent.futures.Executor`; by default this process. The runs are the
            same to the last bit, except for the time that a step took.
        progress: Called with (runs done, runs in all).

    Returns:
        Runs by scenario and label: `runs["xarm7_line"]["J-PARSE"]`.

    Raises:
        InputError: Two scenarios have the same name, there is no method to run, or a parameter is not valid.
    """
    given = [scenarios] if isinstance(scenarios, Scenario) else list(scenarios)
    names = [scenario.name for scenario in given]
    if len(set(names)) < len(names):
        raise InputError(f"each scenario needs a name of its own, got {listed(names)}")
    pieces = [piece for scenario in given for piece in _runs_of(scenario, methods)]
    runs: dict[str, dict[str, Trajectory]] = {name: {} for name in names}
    for piece, run in zip(pieces, run_pieces(_ComparedRun.run, pieces, executor, progress)):
        # The robot of a worker's run is a copy.
        runs[piece.scenario.name][piece.label] = replace(run, robot=piece.scenario.robot)
    return runs


@dataclass(frozen=True, eq=False)
class _ComparedRun:
    """One scenario with one method."""

    scenario: Scenario
    label: str
    method: Method

    def run(self) -> Trajectory:
        """The run, named by the method's label; it shows no progress of its own."""
        return replace(simulate(self.scenario, self.method, progress=_untold), name=self.label)


def _runs_of(scenario: Scenario, methods: Mapping[str, Method] | None) -> list[_ComparedRun]:
    chosen = replace(scenario, methods=scenario.methods if methods is None else methods).methods  # the methods, checked
    if not chosen:
        raise InputError(f"{scenario.name} names no methods: name some")
    # Each run has its own method only, so that other methods need not be sent to its worker.
    alone = replace(scenario, methods={})
    return [_ComparedRun(alone, label, method) for label, method in chosen.items()]


def _untold(done: int, total: int) -> None:
    """Ignores progress."""
