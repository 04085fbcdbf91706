"""What of this package is measured in closed loop: a line adds one."""

from __future__ import annotations

import robust_ik as rik

INVERSE = rik.JParse(0.02)
"""As a controller has it that is told nothing."""
METHODS: dict[str, rik.Resolver] = {
    "Sliding()": rik.TaskPriority(INVERSE, rik.Sliding()),
    "Saturation()": rik.TaskPriority(INVERSE, rik.Saturation()),
    "Scaling()": rik.TaskPriority(INVERSE, rik.Scaling()),
    "QuadraticProgram(keep_direction=True)": rik.TaskPriority(INVERSE, rik.QuadraticProgram(keep_direction=True)),
    "QuadraticProgram()": rik.TaskPriority(INVERSE, rik.QuadraticProgram()),
    "JParse()": rik.TaskPriority(rik.JParse()),
    "DampedLeastSquares(0.05)": rik.TaskPriority(rik.DampedLeastSquares(0.05)),
    "TaskReconstruction()": rik.TaskReconstruction(),
    "WeightedPriority()": rik.WeightedPriority(INVERSE),
}
"""By what they differ in from a controller that is told nothing."""
