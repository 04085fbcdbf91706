"""The inverse of a pose by PyKDL: `ChainIkSolverPos_LMA`, restarted until an answer is right and within the limits."""

from __future__ import annotations

import argparse

import numpy as np
import PyKDL
from poses import restarted
from pykdl_chain import array, chain, frame, pose_of, version
from timing import System, Work, run


def make(work: Work, _: argparse.Namespace) -> System:
    made = chain(work)
    solver = PyKDL.ChainIkSolverPos_LMA(made, np.ones(6), 1e-5, 100)
    n = work.q.shape[1]
    found, pose = PyKDL.JntArray(n), pose_of(made)

    def attempt(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        solver.CartToJnt(array(q), frame(target), found)
        return np.array([found[i] for i in range(n)])

    return System(restarted(attempt, pose, work), pose)


if __name__ == "__main__":
    run("PyKDL", "PyKDL", make, version=version())
