"""What every script that runs in closed loop shares: the runs, the way there, and what is kept of it. Needs NumPy only.

All systems get the same runs: a start, a target for each tool, a cap on the tool's speed. A system that is told a place
and not a speed gets the place on the straight way where the tool should be after the next step (`ahead`).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

REST = 1e-6
"""rad/s: where all joints stay below for a second, the arm rests and the run ends early."""
TAIL = 1.0
"""Seconds of joint velocities that are kept, at the end of a run."""


@dataclass(frozen=True, eq=False)
class Loop:
    """Runs from a start towards targets that stand still.

    Attributes:
        q: Starts, (N, n).
        targets: Where the k tools should go, (N, k, 4, 4).
        poses: Where the tools are at q, (N, k, 4, 4): a system with another idea of it solves another task.
        lower: Lower joint limits, rad, (n,).
        upper: Upper joint limits, rad, (n,).
        speeds: Speed limits, rad/s, (n,).
        joints: Joint names.
        tips: The tool frames, (k,).
        urdf: The robot.
        dt: Seconds.
        steps: How many a run has at the most.
        gain: Wanted speed by error, 1/s.
        caps: The tool's greatest speed, m/s and rad/s.
    """

    q: np.ndarray
    targets: np.ndarray
    poses: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    speeds: np.ndarray
    joints: tuple[str, ...]
    tips: tuple[str, ...]
    urdf: str
    dt: float
    steps: int
    gain: float
    caps: tuple[float, float]

    def save(self, path: Path) -> Path:
        """Writes it to an .npz file."""
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(path, **vars(self))
        return path

    @classmethod
    def read(cls, path: Path) -> Loop:
        """What `save` wrote."""
        with np.load(path) as file:
            arrays: dict[str, Any] = {each.name: file[each.name] for each in fields(cls)}
        for name in ("joints", "tips"):
            arrays[name] = tuple(map(str, arrays[name]))
        scalars = {"urdf": str(arrays["urdf"]), "dt": float(arrays["dt"]), "steps": int(arrays["steps"])}
        return cls(**{**arrays, **scalars, "gain": float(arrays["gain"]), "caps": tuple(arrays["caps"])})


@dataclass(frozen=True)
class Servo:
    """A system to run.

    Attributes:
        step: From (q, targets of all tools) to joint velocities; a step that it refuses raises.
        poses: From q to the tools' poses, (k, 4, 4).
        begin: Forgets the run before.
    """

    step: Callable[[np.ndarray, np.ndarray], np.ndarray]
    poses: Callable[[np.ndarray], np.ndarray]
    begin: Callable[[], None] = lambda: None


def driven(servo: Servo, loop: Loop, q: np.ndarray, targets: np.ndarray) -> dict[str, Any]:
    """One run by explicit Euler: where it ends, how joints moved in the last second, how far limits were broken.

    Args:
        servo: The system. In a step that it refuses the arm stands still.
        loop: Limits, steps and caps.
        q: The start, (n,).
        targets: For each tool, (k, 4, 4).
    """
    tail: deque[np.ndarray] = deque(maxlen=round(TAIL / loop.dt))
    excess, refused, steps = np.zeros(2), 0, 0
    servo.begin()
    while steps < loop.steps:
        steps += 1
        qdot = _answer(servo, q, targets)
        if qdot is None:
            refused, qdot = refused + 1, np.zeros_like(q)
        q = q + loop.dt * qdot
        over = np.maximum(q - loop.upper, loop.lower - q).max(), (np.abs(qdot) - loop.speeds).max()
        excess = np.maximum(excess, over)
        tail.append(qdot)
        if len(tail) == tail.maxlen and np.abs(tail).max() < REST:
            break
    kept = np.array(tail).round(9).tolist()
    return {"q": q.tolist(), "tail": kept, "excess": excess.tolist(), "refused": refused, "steps": steps}


def _answer(servo: Servo, q: np.ndarray, targets: np.ndarray) -> np.ndarray | None:
    """Joint velocities, or None where the system gives none."""
    try:
        qdot = np.asarray(servo.step(q.copy(), targets), dtype=float)
    except Exception:  # each system has errors of its own
        return None
    return qdot if qdot.shape == q.shape and np.isfinite(qdot).all() else None


def ahead(loop: Loop, poses: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """Where the tools should be after the next step, (k, 4, 4): straight on, no faster than the caps.

    Args:
        loop: Gain, caps and dt.
        poses: Where they are, (k, 4, 4).
        targets: Where they should be in the end.
    """
    found = targets.copy()
    for pose, target, near in zip(poses, targets, found):
        way = capped(loop.gain * (target[:3, 3] - pose[:3, 3]), loop.caps[0])
        turn = capped(loop.gain * rotation_vector(target[:3, :3] @ pose[:3, :3].T), loop.caps[1])
        near[:3, 3] = pose[:3, 3] + loop.dt * way
        near[:3, :3] = rotation(loop.dt * turn) @ pose[:3, :3]
    return found


def capped(vector: np.ndarray, most: float) -> np.ndarray:
    """The vector, no longer than that."""
    return vector * min(1.0, most / max(float(np.linalg.norm(vector)), 1e-300))


def rotation(vector: np.ndarray) -> np.ndarray:
    """The rotation about a vector by its length, (3, 3)."""
    angle = float(np.linalg.norm(vector))
    cross = np.cross(vector, np.eye(3)).T  # cross @ v = vector × v
    return np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * cross @ cross


def rotation_vector(R: np.ndarray) -> np.ndarray:
    """The shortest vector whose `rotation` R is, (3,)."""
    half = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine, cosine = float(np.linalg.norm(half)), 0.5 * (np.trace(R) - 1)
    angle = np.arctan2(sine, cosine)
    if cosine > -0.99:
        return half * (angle / sine if sine > 1e-12 else 1.0)
    symmetric = 0.5 * (R + R.T) - cosine * np.eye(3)  # (1 − cos) times axis axisᵀ
    axis = symmetric[np.argmax(np.diag(symmetric))]
    axis = axis / np.linalg.norm(axis)
    return angle * (axis if axis @ half >= 0 else -axis)
