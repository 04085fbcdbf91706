"""What every peer's script shares: the work, the clock and the answers. Needs NumPy only, so it runs anywhere.

A script is started once and then asked for rounds, so that systems take turns at short intervals: for every line on its
standard input it does all the work and answers with a line of JSON.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import os
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from itertools import starmap
from pathlib import Path
from typing import Any

import numpy as np

LEAST, MOST_PASSES = 30_000_000, 50
"""Nanoseconds of CPU time that a round takes at least, and how often it goes over the same rows for that."""
WARM_UP = 20


@dataclass(frozen=True, eq=False)
class Work:
    """Tasks that have nothing to do with each other, so that nothing can be carried over.

    Attributes:
        q: Configurations to be at or to start from, (N, n).
        targets: Where the tool should go, (N, 4, 4), or how fast, (N, 6), linear first, world axes.
        poses: Where the tool is at q, (N, 4, 4): a system with another idea of it solves another task.
        posture: Where the joints should go, (n,).
        lower: Lower joint limits, rad, (n,).
        upper: Upper joint limits, rad, (n,).
        speeds: Speed limits, rad/s, (n,): for a system whose file format has none.
        placements: A of A_1 Rz(q_1) A_2 Rz(q_2) … A_n Rz(q_n) T, (n, 4, 4): for a system that reads no URDF.
        tool: T, (4, 4).
        tolerance: What counts as solved, m and rad, (2,).
        joints: Joint names.
        tip: The tool frame.
        urdf: The robot.
        dt: Seconds.
    """

    q: np.ndarray
    targets: np.ndarray
    poses: np.ndarray
    posture: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    speeds: np.ndarray
    placements: np.ndarray
    tool: np.ndarray
    tolerance: np.ndarray
    joints: tuple[str, ...]
    tip: str
    urdf: str
    dt: float

    def save(self, path: Path) -> Path:
        """Writes it to an .npz file."""
        np.savez(path, **vars(self))
        return path

    @classmethod
    def read(cls, path: Path) -> Work:
        """What `save` wrote."""
        with np.load(path) as file:
            arrays: dict[str, Any] = {each.name: file[each.name] for each in fields(cls)}
        scalars = {"tip": str(arrays["tip"]), "urdf": str(arrays["urdf"]), "dt": float(arrays["dt"])}
        return cls(**{**arrays, **scalars, "joints": tuple(map(str, arrays["joints"]))})


@dataclass(frozen=True)
class System:
    """A system to measure.

    Attributes:
        step: From (q, target) to joint velocities or joint values: the whole work, kinematics included.
        pose: From q to the tool's pose, (4, 4).
    """

    step: Callable[[np.ndarray, np.ndarray], np.ndarray]
    pose: Callable[[np.ndarray], np.ndarray]


Make = Callable[[Work, argparse.Namespace], System]


@dataclass(frozen=True, eq=False)
class Sample:
    """One round of one system.

    Attributes:
        cpu_us: CPU time of the process per call: the whole round by the count, no clock between calls.
        us: Wall time of each call, in a second pass, (N,): for spread and tails.
        answers: What the first pass returned.
    """

    cpu_us: float
    us: np.ndarray
    answers: Sequence[Any]


def sample(step: Callable[..., Any], *columns: Iterable[Any]) -> Sample:
    """Times `step` of every row of some columns: without a clock between calls, and once with one.

    Without one, as often as it takes for a time that can be measured: what is fast has cold caches at first.
    """
    rows = list(zip(*columns))
    begin = time.process_time_ns()
    answers = list(starmap(step, rows))
    cpu, passes = time.process_time_ns() - begin, 1
    while cpu < LEAST and passes < MOST_PASSES:
        begin = time.process_time_ns()
        deque(starmap(step, rows), maxlen=0)
        cpu, passes = cpu + time.process_time_ns() - begin, passes + 1
    clock, marks = time.perf_counter_ns, []
    for row in rows:
        start = clock()
        step(*row)
        marks.append(clock() - start)
    return Sample(1e-3 * cpu / (len(rows) * passes), 1e-3 * np.array(marks), answers)


def run(name: str, package: str, make: Make, *, version: str | None = None, **options: tuple[str, ...]) -> None:
    """The command line of a script: does what `make` makes once for every line on standard input.

    Args:
        name: The system.
        package: What its version is that of.
        make: Builds the system; not measured.
        version: The version of a package that pip does not know.
        options: Further options, their possible values, the default first.
    """

    def begin(path: Path, arguments: argparse.Namespace) -> Callable[[], dict[str, Any]]:
        work = Work.read(path)
        system = make(work, arguments)
        _check(system, work)
        return lambda: _timed(system, work)

    serve(name, package, begin, version=version, **options)


Begin = Callable[[Path, argparse.Namespace], Callable[[], dict[str, Any]]]
"""From the file of a work and the options to what answers one line."""


def serve(name: str, package: str, begin: Begin, *, version: str | None = None, **options: tuple[str, ...]) -> None:
    """A line of JSON that says who answers, and then one for every line on standard input; see `run`."""
    parser = argparse.ArgumentParser(description=f"Runs {name}: one round for every line on standard input.")
    parser.add_argument("work", type=Path, help="an .npz file with the work")
    for option, values in options.items():
        parser.add_argument(f"--{option}", choices=values, default=values[0])
    arguments = parser.parse_args()
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # a library that prints must not be taken for an answer
    answer = begin(arguments.work, arguments)
    chosen = {option: getattr(arguments, option) for option in options}
    hello = {"peer": name, "version": version or importlib.metadata.version(package), **chosen}
    print(json.dumps(hello), file=answers, flush=True)
    for _ in sys.stdin:
        print(json.dumps(answer()), file=answers, flush=True)


def _timed(system: System, work: Work) -> dict[str, Any]:
    done = sample(system.step, work.q, work.targets)
    return {"cpu_us": done.cpu_us, "us": done.us.round(3).tolist(), "answers": np.array(done.answers).tolist()}


def _check(system: System, work: Work) -> None:
    for q, pose in zip(work.q[:WARM_UP], work.poses):
        if not np.allclose(system.pose(q), pose, atol=1e-6):
            raise SystemExit("another tool pose than robust_ik's: not the same task")
    for q, target in zip(work.q[:WARM_UP], work.targets):
        system.step(q, target)


def error(pose: np.ndarray, target: np.ndarray) -> np.ndarray:
    """How far one pose is from another, m and rad, (..., 2)."""
    moved = np.linalg.norm(pose[..., :3, 3] - target[..., :3, 3], axis=-1)
    R = np.swapaxes(pose[..., :3, :3], -1, -2) @ target[..., :3, :3]
    skew = np.stack([R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]], axis=-1)
    return np.stack([moved, np.arctan2(np.linalg.norm(skew, axis=-1), np.trace(R, axis1=-2, axis2=-1) - 1)], axis=-1)
