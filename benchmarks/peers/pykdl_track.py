"""PyKDL along a path: `ChainIkSolverVel_wdls`; `lambda` is its damping, `eps` the σ below which it damps.

Rows that are not controlled get no weight in task space.
"""

from __future__ import annotations

import numpy as np
import PyKDL
from pykdl_chain import array, chain, pose_of, version
from tracking import Arm, Tracker, run


def make(arm: Arm) -> Tracker:
    made = chain(arm)
    given = dict(arm.parameters)
    solver = PyKDL.ChainIkSolverVel_wdls(made, *([given["eps"]] if "eps" in given else []))
    if "lambda" in given:
        solver.setLambda(given["lambda"])
    weights = np.diag([float(place in arm.chosen) for place in range(6)])
    solver.setWeightTS(weights.tolist())
    n = len(arm.joints)
    found = PyKDL.JntArray(n)

    def step(q: np.ndarray, twist: np.ndarray, _: np.ndarray) -> np.ndarray:
        x, y, z, wx, wy, wz = twist.tolist()
        solver.CartToJnt(array(q), PyKDL.Twist(PyKDL.Vector(x, y, z), PyKDL.Vector(wx, wy, wz)), found)
        return np.array([found[i] for i in range(n)])

    return Tracker(step, pose_of(made))


if __name__ == "__main__":
    run("PyKDL", "PyKDL", make, version=version())
