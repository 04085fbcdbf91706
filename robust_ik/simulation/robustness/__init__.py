"""The benchmark of singularity-robust control: scenarios from an atlas, runs, scores, the Pareto front."""

from robust_ik.simulation.robustness.benchmark_methods import (
    BenchmarkMethod,
    ControllerMethod,
    InverseMethod,
    documented,
)
from robust_ik.simulation.robustness.benchmark_results import BenchmarkResults, facts, key_of, measure, scored
from robust_ik.simulation.robustness.benchmark_scenario import KINDS, RobustnessScenario
from robust_ik.simulation.robustness.benchmark_summary import (
    OBJECTIVES,
    PRICES,
    MethodSummary,
    RunKey,
    by_class,
    means_of,
    price,
    summaries,
)
from robust_ik.simulation.robustness.lockstep_runs import RunTrace, run_scenarios
from robust_ik.simulation.robustness.method_files import CONTROLLER, chosen_methods, known_methods
from robust_ik.simulation.robustness.pareto_front import dominated_by
from robust_ik.simulation.robustness.run_metrics import RunScore, score
from robust_ik.simulation.robustness.scenario_generation import robustness_scenarios

__all__ = [
    "CONTROLLER",
    "KINDS",
    "OBJECTIVES",
    "PRICES",
    "BenchmarkMethod",
    "BenchmarkResults",
    "ControllerMethod",
    "InverseMethod",
    "MethodSummary",
    "RobustnessScenario",
    "RunKey",
    "RunScore",
    "RunTrace",
    "by_class",
    "chosen_methods",
    "documented",
    "dominated_by",
    "facts",
    "key_of",
    "known_methods",
    "means_of",
    "measure",
    "price",
    "robustness_scenarios",
    "run_scenarios",
    "score",
    "scored",
    "summaries",
]
