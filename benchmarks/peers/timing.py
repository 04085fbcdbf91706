"""What every step script shares: the work, the clock and the line of JSON. Needs NumPy only, so it runs anywhere."""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

WARM_UP = 20


@dataclass(frozen=True)
class Work:
    """Control steps that have nothing to do with each other, so that nothing can be carried over.

    Attributes:
        q: Configurations, (N, n).
        targets: Where the tool should go, (N, 4, 4).
        poses: Where the tool is, (N, 4, 4): a system with another idea of it solves another task.
        posture: Where the joints should go, (n,).
        speeds: Speed limits, rad/s, (n,): for a system whose file format has none.
        joints: Joint names.
        tip: The tool frame.
        urdf: The robot.
        dt: Seconds.
    """

    q: np.ndarray
    targets: np.ndarray
    poses: np.ndarray
    posture: np.ndarray
    speeds: np.ndarray
    joints: tuple[str, ...]
    tip: str
    urdf: str
    dt: float

    def save(self, path: Path) -> None:
        """Writes it to an .npz file."""
        np.savez(path, **vars(self))

    @classmethod
    def read(cls, path: Path) -> Work:
        """What `save` wrote."""
        with np.load(path) as file:
            scalars = {"tip": str(file["tip"]), "urdf": str(file["urdf"]), "dt": float(file["dt"])}
            arrays = {name: file[name] for name in ("q", "targets", "poses", "posture", "speeds")}
            return cls(joints=tuple(map(str, file["joints"])), **arrays, **scalars)


@dataclass(frozen=True)
class System:
    """A system to measure.

    Attributes:
        step: From (q, target) to joint velocities: one whole control step, kinematics and target included.
        pose: From q to the tool's pose, (4, 4).
    """

    step: Callable[[np.ndarray, np.ndarray], np.ndarray]
    pose: Callable[[np.ndarray], np.ndarray]


Make = Callable[[Work, argparse.Namespace], System]


def run(name: str, package: str, make: Make, **options: tuple[str, ...]) -> None:
    """The command line of a step script: measures what `make` makes and prints one line of JSON.

    Args:
        name: The system.
        package: What its version is that of.
        make: Builds the system; not measured.
        options: Further options, their possible values, the default first.
    """
    parser = argparse.ArgumentParser(description=f"Times one control step of {name}.")
    parser.add_argument("work", type=Path, help="what benchmarks/step_with_limits.py wrote")
    parser.add_argument("--velocities", type=Path, help="where to save the joint velocities (.npy)")
    for option, values in options.items():
        parser.add_argument(f"--{option}", choices=values, default=values[0])
    arguments = parser.parse_args()
    work = Work.read(arguments.work)
    seconds, qdot = _measured(make(work, arguments), work)
    if arguments.velocities:
        np.save(arguments.velocities, qdot)
    us = {"min": round(1e6 * float(seconds.min()), 2), "median": round(1e6 * float(np.median(seconds)), 2)}
    version = importlib.metadata.version(package)
    chosen = {option: getattr(arguments, option) for option in options}
    print(json.dumps({"peer": name, "version": version, "us_per_step": us, "steps": len(seconds), **chosen}))


def _measured(system: System, work: Work) -> tuple[np.ndarray, np.ndarray]:
    """Seconds per step, (N,), and joint velocities, (N, n)."""
    for q, pose in zip(work.q[:WARM_UP], work.poses):
        if not np.allclose(system.pose(q), pose, atol=1e-6):
            raise SystemExit("another tool pose than robust_ik's: not the same task")
    for q, target in zip(work.q[:WARM_UP], work.targets):
        system.step(q, target)
    seconds, qdot = np.empty(len(work.q)), np.empty(work.q.shape)
    for i, (q, target) in enumerate(zip(work.q, work.targets)):
        start = time.perf_counter()
        result = system.step(q, target)
        seconds[i] = time.perf_counter() - start
        qdot[i] = result
    return seconds, qdot
