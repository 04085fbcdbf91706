"""What of this package is measured in closed loop: a line adds one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import robust_ik as rik

INVERSE = rik.JParse(0.01)
"""As a controller has it that is told nothing."""


@dataclass(frozen=True, eq=False)
class Method:
    """A resolver, and what a redundant arm does with the freedom that is left.

    Attributes:
        resolver: The resolver.
        below: Tasks of a level below the tools'.
    """

    resolver: rik.Resolver
    below: tuple[rik.Task, ...] = ()


RESOLVERS: dict[str, rik.Resolver] = {
    "Sliding()": rik.TaskPriority(INVERSE, rik.Sliding(), steady=True),
    "Saturation()": rik.TaskPriority(INVERSE, rik.Saturation(), steady=True),
    "Scaling()": rik.TaskPriority(INVERSE, rik.Scaling(), steady=True),
    "QuadraticProgram(keep_direction=True)": rik.TaskPriority(
        INVERSE, rik.QuadraticProgram(keep_direction=True), steady=True
    ),
    "QuadraticProgram()": rik.TaskPriority(INVERSE, rik.QuadraticProgram(), steady=True),
    "JParse()": rik.TaskPriority(rik.JParse()),
    "DampedLeastSquares(0.05)": rik.TaskPriority(rik.DampedLeastSquares(0.05)),
    "TaskReconstruction()": rik.TaskReconstruction(steady=True),
    "WeightedPriority()": rik.WeightedPriority(INVERSE, steady=True),
}
METHODS = {name: Method(resolver) for name, resolver in RESOLVERS.items()}
METHODS["Sliding() over JointRangeTask()"] = Method(RESOLVERS["Sliding()"], (rik.JointRangeTask(),))
"""By what they differ in from a controller that is told nothing."""


Parts = tuple[Callable[[np.ndarray, np.ndarray], np.ndarray], Callable[[np.ndarray], np.ndarray], Callable[[], None]]


def parts(
    robot: rik.Robot, resolver: Any, limits: Sequence[rik.Limit], loop: Any, below: Sequence[rik.Task] = (),
    *, calm: bool = True,
) -> Parts:  # fmt: skip
    """What `loops.Servo` is made of, for a controller that drives the tools of a `loops.Loop` to their targets.

    Args:
        robot: The loop's.
        resolver: A resolver or an inverse.
        limits: The strongest first; () for none.
        loop: Gain, caps, tools and dt.
        below: Tasks of a level below.
        calm: As for `VelocityController`.
    """
    levels = [list(below)] if below else []
    controller = rik.VelocityController(robot, resolver, limits, calm=calm)
    caps = {"max_linear": loop.caps[0] / loop.gain, "max_angular": loop.caps[1] / loop.gain}

    def step(q: np.ndarray, targets: np.ndarray) -> np.ndarray:
        hands = [rik.FrameTask(target, loop.gain, frame=tip, **caps) for target, tip in zip(targets, loop.tips)]
        return controller.step(q, [hands, *levels], loop.dt).qdot

    def poses(q: np.ndarray) -> np.ndarray:
        return np.array([robot.pose(q, tip) for tip in loop.tips])

    return step, poses, controller.reset


def robot_of(loop: Any) -> rik.Robot:
    """The robot of a `loops.Loop`."""
    return rik.load(loop.urdf, tip=loop.tips[0], whole_tree=len(loop.tips) > 1)
