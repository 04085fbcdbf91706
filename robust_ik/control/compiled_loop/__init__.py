"""A controller's step in compiled code: rows of tasks, bounds of limits, and the walk down the levels."""

from robust_ik.control.compiled_loop.compiled_steps import UnreadReport
from robust_ik.control.compiled_loop.step_reports import StepReports

__all__ = [
    "StepReports",
    "UnreadReport",
]
