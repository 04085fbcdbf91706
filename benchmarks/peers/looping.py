"""The command line of a script that runs in closed loop."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from loops import Loop, Servo, driven
from timing import serve

Make = Callable[[Loop, argparse.Namespace], Servo]


def run(name: str, package: str, make: Make, *, version: str | None = None, **options: tuple[str, ...]) -> None:
    """Does all runs once for every line on standard input; see `timing.run`."""

    def begin(path: Path, arguments: argparse.Namespace) -> Callable[[], dict[str, Any]]:
        loop = Loop.read(path)
        servo = make(loop, arguments)
        for q, poses in zip(loop.q, loop.poses):
            if not np.allclose(servo.poses(q), poses, atol=1e-6):
                raise SystemExit("another tool pose than robust_ik's: not the same task")
        return lambda: _all(servo, loop)

    serve(name, package, begin, version=version, **options)


def _all(servo: Servo, loop: Loop) -> dict[str, Any]:
    start = time.process_time_ns()
    answers = [driven(servo, loop, *each) for each in zip(loop.q, loop.targets)]
    cpu = 1e-3 * (time.process_time_ns() - start) / sum(each["steps"] for each in answers)
    return {"cpu_us": cpu, "us": [], "answers": answers}
