"""What of this package is measured in closed loop: a line adds one."""

from __future__ import annotations

import robust_ik as rik

METHODS: dict[str, rik.Resolver] = {
    "Sliding()": rik.TaskPriority(rik.JParse(), rik.Sliding()),
    "Saturation()": rik.TaskPriority(rik.JParse(), rik.Saturation()),
    "Scaling()": rik.TaskPriority(rik.JParse(), rik.Scaling()),
    "QuadraticProgram(keep_direction=True)": rik.TaskPriority(rik.JParse(), rik.QuadraticProgram(keep_direction=True)),
    "QuadraticProgram()": rik.TaskPriority(rik.JParse(), rik.QuadraticProgram()),
    "DampedLeastSquares(0.05)": rik.TaskPriority(rik.DampedLeastSquares(0.05)),
    "TaskReconstruction()": rik.TaskReconstruction(),
    "WeightedPriority()": rik.WeightedPriority(),
}
"""By what they differ in from `TaskPriority(JParse())` with its default limiter."""
