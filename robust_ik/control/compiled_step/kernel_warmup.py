"""Compiles kernels ahead of time, so that nothing is compiled, or read from disk, in a control loop."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

from robust_ik.checks.public_arguments import checked
from robust_ik.inverses import CLASSES, GainFormula
from robust_ik.robot.robot import Robot
from robust_ik.runtime.progress import ProgressCallback

SMALLEST = 8
"""The smallest kernels are for this many joints, rows and columns."""


@checked
def warmup(robot: Robot | None = None, *, progress: ProgressCallback | None = None) -> float:
    """Compiles all kernels, or reads them from disk if they have been compiled on this machine before.

    The first time on a machine takes about three minutes of one core, later ones a fraction of a second; docs/speed.md
    has the seconds of each kernel, where compiled code is kept, and what to do if nothing can be written.

    Args:
        robot: Leave out kernels for robots of other sizes; by default compile everything, for any robot.
        progress: Called with (done, in all), which count kernels and gain formulas.

    Returns:
        The time taken, s.
    """
    began = time.perf_counter()
    from robust_ik.kernels.compiler.gain_callbacks import address_of
    from robust_ik.kernels.loader.kernel import every_kernel

    kernels = [each for each in every_kernel() if robot is None or _serves(each.most, robot.n)]
    jobs: list[Callable[[], object]] = [partial(getattr, each, "compiled") for each in kernels]
    jobs += [partial(address_of, each.formula) for each in CLASSES if issubclass(each, GainFormula)]
    for done, job in enumerate(jobs):
        if progress is not None:
            progress(done, len(jobs))
        job()
    if progress is not None:
        progress(len(jobs), len(jobs))
    return time.perf_counter() - began


def _serves(most: int | None, n: int) -> bool:
    """Whether a kernel is for a robot of n joints, or for matrices of at most six rows, which every robot has."""
    return most is None or most <= SMALLEST or (n > SMALLEST and n <= most)
