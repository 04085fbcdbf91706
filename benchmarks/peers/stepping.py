"""The command line of a script that makes single steps of several tools at once, from configurations along a motion."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from loops import Loop, Servo
from timing import WARM_UP, sample, serve

Make = Callable[[Loop, argparse.Namespace], Servo]


def run(name: str, package: str, make: Make, **options: tuple[str, ...]) -> None:
    """Makes all steps once for every line on standard input; see `timing.run`."""

    def begin(path: Path, arguments: argparse.Namespace) -> Callable[[], dict[str, Any]]:
        loop = Loop.read(path)
        servo = make(loop, arguments)
        for q, poses, targets in list(zip(loop.q, loop.poses, loop.targets))[:WARM_UP]:
            if not np.allclose(servo.poses(q), poses, atol=1e-6):
                raise SystemExit("another tool pose than robust_ik's: not the same task")
            servo.step(q, targets)
        return lambda: _timed(servo, loop)

    serve(name, package, begin, **options)


def _timed(servo: Servo, loop: Loop) -> dict[str, Any]:
    done = sample(servo.step, loop.q, loop.targets)
    return {"cpu_us": done.cpu_us, "us": done.us.round(3).tolist(), "answers": np.array(done.answers).tolist()}
