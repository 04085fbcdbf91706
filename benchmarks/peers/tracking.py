"""Runs a system along the scenarios of the robustness benchmark. Needs NumPy only, so it runs anywhere.

Every step it is told a twist, by feedback to the target of that step, and the place where the tool would be after the
step with it. The commands, the drive and the noise are those of `robust_ik.simulation.robustness`; a test compares
both. Joint values and commands go back in a file, and are judged by who asked.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from loops import rotation, rotation_vector
from timing import serve

ROWS = ("x", "y", "z", "wx", "wy", "wz")
WILD = 100.0
"""Commands are executed up to so many times a speed limit where there is no drive."""


@dataclass(frozen=True, eq=False)
class Arm:
    """What a system is made for.

    Attributes:
        urdf: The robot.
        tip: The tool frame.
        joints: Joint names.
        placements: As in `timing.Work`, (n, 4, 4): for a system that reads no URDF.
        tool: The same, (4, 4).
        rows: Task rows, of ROWS.
        parameters: Settings other than the system's own, by name.
        speed: Speed limits, rad/s, (n,).
        dt: Time step, s.
    """

    urdf: str
    tip: str
    joints: tuple[str, ...]
    placements: np.ndarray
    tool: np.ndarray
    rows: tuple[str, ...]
    parameters: dict[str, float]
    speed: np.ndarray
    dt: float

    @property
    def turns(self) -> bool:
        """Whether rotations are controlled."""
        return any(row.startswith("w") for row in self.rows)

    @property
    def chosen(self) -> list[int]:
        """Places of its rows in a twist."""
        return [ROWS.index(row) for row in self.rows]


@dataclass(frozen=True)
class Tracker:
    """A system to run.

    Attributes:
        step: From (q, twist (6,), place of the tool after the step (4, 4)) to joint velocities.
        pose: From q to the tool's pose, (4, 4).
    """

    step: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
    pose: Callable[[np.ndarray], np.ndarray]


Make = Callable[[Arm], Tracker]


def run(name: str, package: str, make: Make, *, version: str | None = None) -> None:
    """The command line of a script: makes all runs for a line on standard input, and answers with a file's name."""

    def begin(path: Path, _: argparse.Namespace) -> Callable[[], dict[str, Any]]:
        with np.load(path) as file:
            given = dict(file)
        trackers = {dt: make(arm_of(given, i)) for dt, i in _time_steps(given).items()}
        first = next(iter(trackers.values()))
        for i in range(int(given["count"])):
            if not np.allclose(first.pose(given[f"{i} start"]), given["pose"][i], atol=1e-6):
                raise SystemExit("another tool pose than robust_ik's: not the same task")
        return lambda: _all(trackers, given, path.with_suffix(".answers.npz"))

    serve(name, package, begin, version=version)


def _time_steps(given: dict[str, np.ndarray]) -> dict[float, int]:
    """Each time step with a scenario that has it."""
    return {float(given[f"{i} numbers"][0]): i for i in range(int(given["count"]))}


def arm_of(given: dict[str, np.ndarray], i: int) -> Arm:
    """What a system is made for, of scenario i."""
    return Arm(
        urdf=str(given["urdf"]), tip=str(given["tip"]), joints=tuple(map(str, given["joints"])),
        placements=given["placements"], tool=given["tool"], rows=tuple(map(str, given["rows"])),
        parameters=json.loads(str(given["parameters"])), speed=given[f"{i} speed"], dt=float(given[f"{i} numbers"][0]),
    )  # fmt: skip


def _all(trackers: dict[float, Tracker], given: dict[str, np.ndarray], path: Path) -> dict[str, Any]:
    found: dict[str, Any] = {}
    spent, steps = 0.0, 0
    for i in range(int(given["count"])):
        scenario = {name: given[f"{i} {name}"] for name in SCENARIO}
        q, commanded, failed, seconds = tracked(trackers[float(scenario["numbers"][0])], arm_of(given, i), scenario)
        found |= {f"{i} q": q, f"{i} commanded": commanded, f"{i} failed": failed}
        spent, steps = spent + seconds, steps + len(commanded)
    np.savez(path, seconds=spent / steps, **found)
    return {"cpu_us": 1e6 * spent / steps, "us": [], "answers": str(path)}


SCENARIO = ("start", "targets", "forward", "of_joints", "of_rows", "units", "speed", "acceleration", "numbers")
"""What is read of each scenario."""


def tracked(tracker: Tracker, arm: Arm, scenario: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray, int, float]:
    """One run: joint values, (S + 1, n), commanded velocities, (S, n), steps that failed, seconds in all steps."""
    dt, gain, cap, drive = scenario["numbers"].tolist()
    speed, reach = scenario["speed"], scenario["acceleration"] * dt
    steps, n = scenario["of_joints"].shape
    q, commanded = np.empty((steps + 1, n)), np.zeros((steps, n))
    q[0], last, failed, seconds = scenario["start"], np.zeros(n), 0, 0.0
    for k in range(steps):
        measured = q[k] + scenario["of_joints"][k]
        pose = tracker.pose(measured)
        error = np.concatenate([
            scenario["targets"][k, :3, 3] - pose[:3, 3],
            rotation_vector(scenario["targets"][k, :3, :3] @ pose[:3, :3].T),
        ])  # fmt: skip
        scaled = (scenario["forward"][k] + gain * error[arm.chosen]) / scenario["units"]
        scaled *= min(1.0, cap / max(float(np.linalg.norm(scaled)), 1e-300))
        twist = np.zeros(6)
        twist[arm.chosen] = (scaled + scenario["of_rows"][k]) * scenario["units"]
        began = time.perf_counter()
        given = _answer(tracker, measured, twist, ahead(pose, dt * twist))
        seconds += time.perf_counter() - began
        failed += given is None
        commanded[k] = 0.0 if given is None else given
        last = executed(commanded[k], last, speed, reach) if drive else _tamed(commanded[k], speed)
        q[k + 1] = q[k] + dt * last
    return q, commanded, failed, seconds


def executed(commanded: np.ndarray, last: np.ndarray, speed: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """What a drive makes of a command: evenly slowed into the speed limits, then cut to what a step can change."""
    slowed = commanded / max(1.0, float(np.max(np.abs(commanded) / speed)))
    return np.clip(slowed, np.maximum(-speed, last - reach), np.minimum(speed, last + reach))


def _tamed(commanded: np.ndarray, speed: np.ndarray) -> np.ndarray:
    return commanded * min(1.0, WILD / max(float(np.max(np.abs(commanded) / speed)), 1e-300))


def ahead(pose: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """A pose shifted and turned about world axes by a small motion, m and rad, (6,)."""
    near = pose.copy()
    near[:3, 3] += moved[:3]
    near[:3, :3] = rotation(moved[3:]) @ pose[:3, :3]
    return near


def _answer(tracker: Tracker, q: np.ndarray, twist: np.ndarray, near: np.ndarray) -> np.ndarray | None:
    """Joint velocities, or None where the system gives none."""
    try:
        qdot = np.asarray(tracker.step(q.copy(), twist, near), dtype=float)
    except Exception:  # each system has errors of its own
        return None
    return qdot if qdot.shape == q.shape and np.isfinite(qdot).all() else None
