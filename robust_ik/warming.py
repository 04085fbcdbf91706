"""Compiling ahead: so that nothing is compiled, or read from disk, in a control loop."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from robust_ik.linalg import singular_values, svd
from robust_ik.progress import Told
from robust_ik.robot import Robot


def warmup(robot: Robot | None = None, *, progress: Told | None = None) -> float:
    """Compiles whatever is compiled, or reads it from disk, where a machine keeps it from the first time on.

    The first time on a machine takes a few seconds for each kernel, later ones a second for all of them, most of it to
    import Numba. Where kernels are kept, and what to do where nothing can be written: docs/speed.md.

    Args:
        robot: Compile only what this robot needs, a part of all; by default everything, for any robot.
        progress: Called with (kernels done, kernels in all); with a robot, with jobs done.

    Returns:
        The seconds that it took.
    """
    began = time.perf_counter()
    jobs = _kernels() if robot is None else _jobs(robot)
    for done, job in enumerate(jobs):
        if progress is not None:
            progress(done, len(jobs))
        job()
    if progress is not None:
        progress(len(jobs), len(jobs))
    return time.perf_counter() - began


def _kernels() -> Sequence[Callable[[], object]]:
    from robust_ik.kernels.compiling import every_kernel  # imports Numba, half a second: only where it is needed

    return [partial(getattr, each, "compiled") for each in every_kernel()]


def _jobs(robot: Robot) -> Sequence[Callable[[], object]]:
    """What is asked of a robot, once each."""
    frame = robot.tip or robot.description.leaves[0]
    wide, small = np.zeros((6, robot.n)), np.eye(6)  # there are kernels for matrices of different sizes
    return (
        lambda: robot.pose(robot.rest, frame),
        lambda: robot.jacobian(robot.rest, frame),
        lambda: robot.hessian(robot.rest, frame),
        lambda: (svd(wide), singular_values(wide)),
        lambda: (svd(small), singular_values(small)),
    )
