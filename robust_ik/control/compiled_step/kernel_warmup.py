"""Compiling ahead: so that nothing is compiled, or read from disk, in a control loop."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

from robust_ik.checks.public_arguments import checked
from robust_ik.inverses import CLASSES, GainFormula
from robust_ik.robot.robot import Robot
from robust_ik.runtime.progress import Told

SMALLEST = 8
"""Kernels for so many joints, rows and columns are the smallest there are."""


@checked
def warmup(robot: Robot | None = None, *, progress: Told | None = None) -> float:
    """Compiles whatever is compiled, or reads it from disk, where a machine keeps it from the first time on.

    The first time on a machine takes about two minutes of one core, later ones a second, most of it to import Numba;
    docs/speed.md has the seconds of each kernel, where compiled code is kept, and what to do where nothing can be
    written.

    Args:
        robot: Leave out what is for robots of another size; by default everything, for any robot.
        progress: Called with (done, in all): kernels and formulas of gains.

    Returns:
        The seconds that it took.
    """
    began = time.perf_counter()
    from robust_ik.kernels.compiler.compiling import every_kernel
    from robust_ik.kernels.compiler.gain_callbacks import address_of

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
    """Whether a kernel is for a robot of n joints, or for the matrices of six rows and less that every robot has."""
    return most is None or most <= SMALLEST or (n > SMALLEST and n <= most)
