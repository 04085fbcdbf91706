"""Announces that a kernel will be compiled, if that takes so long that the user would notice.

It is a warning of the logger `robust_ik`, since Python shows warnings of loggers without any set-up: people stop a
program that seems to hang for half a minute.
"""

from __future__ import annotations

import logging

WORTH_SAYING = 3
"""Compile times below this, in seconds, are not announced."""

WHAT = {
    "chain_kinematics": "the kinematics",
    "hessian_contraction": "the derivatives of singular values",
    "small_svd": "the singular value decomposition",
    "levenberg_marquardt": "the search for singular configurations of arms with many joints",
    "second_order_entries": "the second-order inverse",
    "start_table": "the pose solver's table of starts",
    "pose_search": "the pose solver",
    "corank_search": "the search for singular configurations",
    "solution_ladder": "the planner of paths",
    "branch_search": "all solutions of a pose",
    "loop_state": "self-motions",
    "curve_tracing": "self-motions",
    "step_entries": "the velocity step",
    "curved_step": "the second-order velocity step",
    "control_entries": "the control step within limits",
    "run_entries": "many runs of the control step within limits",
}
"""The purpose of each module of kernels, in the words of the announcement."""

SECONDS = {
    "chain_kinematics.poses": 4, "chain_kinematics.jacobians": 1, "chain_kinematics.hessians": 1,
    "hessian_contraction.contractions": 3, "small_svd.vectors_8": 6, "small_svd.vectors_16": 5,
    "small_svd.values_8": 3, "small_svd.values_16": 3, "levenberg_marquardt.steps": 1,
    "second_order_entries.velocity_8": 12, "second_order_entries.velocity_16": 12, "start_table.fill_table": 12,
    "pose_search.solve_one": 12, "pose_search.solve_many": 8, "corank_search.searches_8": 7,
    "corank_search.searches_16": 5, "branch_search.branches": 20, "curve_tracing.follow_curve": 5,
    "loop_state.state_of_loop": 1, "solution_ladder.ladder": 1,
    "step_entries.step_8": 4, "step_entries.step_16": 4,
    "step_entries.beside_8": 4, "step_entries.beside_16": 4, "step_entries.factor_8": 3, "step_entries.factor_16": 3,
    "step_entries.steps_8": 8, "step_entries.steps_16": 7, "control_entries.control_8": 42,
    "control_entries.control_16": 30, "control_entries.control_32": 33,
    "curved_step.curved_8": 12, "curved_step.curved_16": 12, "run_entries.runs_8": 33,
    "run_entries.runs_16": 33, "run_entries.runs_32": 33,
}  # fmt: skip
"""CPU seconds that a kernel takes to compile on one core, as `python -m benchmarks.compile_time` measures them.

Steps within limits take so long if they are the first of their process: later ones share what they call.
"""

MISSED: list[str] = []
"""Names of kernels that this process had to compile since they were nowhere on disk."""


def announce(name: str) -> None:
    """Logs that a kernel, "module.function", is being compiled and how long that takes, if at least WORTH_SAYING."""
    MISSED.append(name)
    if (seconds := SECONDS.get(name, 0)) >= WORTH_SAYING:
        module, _, part = name.partition(".")
        told = f"compiling {WHAT[module]} ({part}), once on this machine, about {seconds} s"
        logging.getLogger("robust_ik").warning(told)
