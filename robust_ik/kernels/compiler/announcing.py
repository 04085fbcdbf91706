"""What is said before a kernel is compiled that somebody would have to wait for.

It is a warning of the logger `robust_ik`, since Python shows warnings of loggers without any set-up: a program that
seems to hang for half a minute is one that people stop.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

WORTH_SAYING = 3
"""Seconds below which nothing is said."""

WHAT = {
    "chain_kinematics": "the kinematics",
    "hessian_contraction": "the derivatives of singular values",
    "small_svd": "the singular value decomposition",
    "levenberg_marquardt": "the search for singular configurations",
    "start_table": "the pose solver's table of starts",
    "pose_search": "the pose solver",
    "step_entries": "the control step",
}
"""What the kernels of a module are for."""

SECONDS = {
    "chain_kinematics.poses": 4, "chain_kinematics.jacobians": 1, "chain_kinematics.hessians": 1,
    "hessian_contraction.contractions": 4, "small_svd.vectors_8": 8, "small_svd.vectors_16": 7,
    "small_svd.values_8": 4, "small_svd.values_16": 5, "levenberg_marquardt.steps": 1, "start_table.fill_table": 13,
    "pose_search.solve_one": 21, "pose_search.solve_many": 10, "step_entries.step_8": 5, "step_entries.step_16": 5,
    "step_entries.beside_8": 5, "step_entries.beside_16": 5, "step_entries.factor_8": 3, "step_entries.factor_16": 3,
    "step_entries.steps_8": 9, "step_entries.steps_16": 10,
}  # fmt: skip
"""CPU seconds that a kernel takes to compile on one core, as `python -m benchmarks.compile_time` measures them."""

MISSED: list[str] = []
"""What this process has had to compile, by module and function: it was nowhere on disk."""


def kernel_name(function: Callable[..., Any]) -> str:
    """The kernel's module, without its packages, and the function's name."""
    return f"{function.__module__.rpartition('.')[2]}.{function.__qualname__}"


def announce(function: Callable[..., Any]) -> None:
    """Says that a kernel is compiled now and how long that takes, where it is worth saying."""
    name = kernel_name(function)
    MISSED.append(name)
    if (seconds := SECONDS.get(name, 0)) >= WORTH_SAYING:
        module, _, part = name.partition(".")
        told = f"compiling {WHAT[module]} ({part}), once on this machine, about {seconds} s"
        logging.getLogger("robust_ik").warning(told)
