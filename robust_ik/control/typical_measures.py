"""Typical measures of manipulability of a stack's levels on a robot, from which bounds are set."""

from __future__ import annotations

import numpy as np

from robust_ik.checks import checked_parameter
from robust_ik.checks.public_arguments import checked
from robust_ik.control.bounds import Bounds
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolvers.step_status import reductions
from robust_ik.control.tasks import Stack, Task, checked_stack
from robust_ik.inverses.task_equation import stacked
from robust_ik.robot.robot import Robot

SAMPLES = 300
"""Number of random configurations. Their median is known to 1.25/√300, 7 % of the measure's spread."""


@checked
def measure_bounds(
    robot: Robot, stack: Stack | Task, fraction: float = 0.2, *, rng: np.random.Generator | None = None
) -> tuple[float, ...]:
    """Bounds m̄ for `TaskReconstruction`: a fraction of the median of each level's measure.

    The median is over random configurations within the limits. A level to which higher ones leave too few joints has
    the measure 0, and the bound 0.

    Args:
        robot: The robot.
        stack: The stack.
        fraction: In (0, 1); 0.2 keeps away from singularities and leaves most of the workspace.
        rng: For the samples; the same ones by default.

    Raises:
        InputError: The fraction is not in (0, 1), or the stack is not valid.
    """
    checked_parameter("fraction", fraction, above=0, below=1)
    levels = checked_stack(stack)
    measures = []
    for q in robot.random(rng or np.random.default_rng(0), SAMPLES):
        equations = tuple(stacked([task.equation(robot, q) for task in level]) for level in levels)
        found = reductions(VelocityProblem(equations, Bounds.free(robot.n)))
        measures.append([each.measure for each in found])
    return tuple(float(fraction * each) for each in np.median(measures, axis=0))
