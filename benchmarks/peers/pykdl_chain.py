"""The robot as PyKDL has it: Debian's python3-pykdl reads no URDF, so it is built from numbers."""

from __future__ import annotations

import subprocess
from collections.abc import Callable

import numpy as np
import PyKDL
from timing import Work


def frame(T: np.ndarray) -> PyKDL.Frame:
    """A homogeneous transform as PyKDL's."""
    return PyKDL.Frame(PyKDL.Rotation(*T[:3, :3].ravel().tolist()), PyKDL.Vector(*T[:3, 3].tolist()))


KEPT: list[PyKDL.Chain] = []
"""Every chain: PyKDL's solvers refer to theirs without keeping it alive."""


def chain(work: Work) -> PyKDL.Chain:
    """A_1 stands still; then each joint turns the next A, and the last one the tool."""
    made = PyKDL.Chain()
    KEPT.append(made)
    made.addSegment(PyKDL.Segment(PyKDL.Joint(PyKDL.Joint.Fixed), frame(work.placements[0])))
    for after in (*work.placements[1:], work.tool):
        made.addSegment(PyKDL.Segment(PyKDL.Joint(PyKDL.Joint.RotZ), frame(after)))
    return made


def array(q: np.ndarray) -> PyKDL.JntArray:
    """Joint values as PyKDL's."""
    made = PyKDL.JntArray(len(q))
    for i, value in enumerate(q):
        made[i] = value
    return made


def pose_of(made: PyKDL.Chain) -> Callable[[np.ndarray], np.ndarray]:
    """From q to the tool's pose, (4, 4)."""
    solver, found = PyKDL.ChainFkSolverPos_recursive(made), PyKDL.Frame()

    def pose(q: np.ndarray) -> np.ndarray:
        solver.JntToCart(array(q), found)
        return np.array([[found[i, j] for j in range(4)] for i in range(3)] + [[0.0, 0, 0, 1]])

    return pose


def version() -> str:
    """Debian's."""
    command = ["dpkg-query", "--show", "--showformat=${Version}", "python3-pykdl"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout
