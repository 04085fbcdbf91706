"""One control step of PyKDL: its damped least squares, `ChainIkSolverVel_wdls`, with λ = 0.05."""

from __future__ import annotations

import argparse

import numpy as np
import PyKDL
from pykdl_chain import chain, pose_of, version
from timing import System, Work, run


def make(work: Work, _: argparse.Namespace) -> System:
    made = chain(work)
    solver = PyKDL.ChainIkSolverVel_wdls(made)
    solver.setLambda(0.05)
    n = work.q.shape[1]
    current, found = PyKDL.JntArray(n), PyKDL.JntArray(n)

    def step(q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        for i, value in enumerate(q.tolist()):
            current[i] = value
        x, y, z, wx, wy, wz = twist.tolist()
        solver.CartToJnt(current, PyKDL.Twist(PyKDL.Vector(x, y, z), PyKDL.Vector(wx, wy, wz)), found)
        return np.array([found[i] for i in range(n)])

    return System(step, pose_of(made))


if __name__ == "__main__":
    run("PyKDL", "PyKDL", make, version=version())
