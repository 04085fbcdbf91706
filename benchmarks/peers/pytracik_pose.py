"""The inverse of a pose by TRAC-IK: its "speed" setting, 50 ms at most."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pytracik
from timing import System, Work, run


def make(work: Work, _: argparse.Namespace) -> System:
    text = Path(work.urdf).read_text(encoding="utf-8")
    kind = pytracik.SolveType.Speed
    solver = pytracik.TRAC_IK("base", work.tip, text, 0.05, float(work.tolerance.min()) / 10, kind)

    def step(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        found = pytracik.ik(solver, q, *target[:3, 3], *quaternion(target))
        return found[1:] if found[0] >= 0 else q

    return System(step, lambda q: pytracik.fk(solver, q))


def quaternion(T: np.ndarray) -> np.ndarray:
    """Of a rotation, x y z w: the eigenvector of Bar-Itzhack's matrix, sound at every angle."""
    R = T[:3, :3]
    K = np.zeros((4, 4))
    K[:3, :3] = R + R.T - np.trace(R) * np.eye(3)
    K[:3, 3] = K[3, :3] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    K[3, 3] = np.trace(R)
    return np.linalg.eigh(K)[1][:, -1]


if __name__ == "__main__":
    run("TRAC-IK", "pytracik", make)
