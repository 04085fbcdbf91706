"""PyKDL along a path: `ChainIkSolverVel_wdls`; `lambda` is its damping, `eps` the σ below which it damps.

Its own default of 0 for `lambda` is the pseudo-inverse, which is not finite where σ is 0: here it is 0.05, as in the
other measurements. Rows that are not controlled get no weight in task space. Its solver needs six joints: a shorter
arm gets further ones behind its tool that have no weight in joint space, so that they never move.
"""

from __future__ import annotations

import numpy as np
import PyKDL
from pykdl_chain import array, chain, pose_of, version
from tracking import Arm, Tracker, run

LEAST, DAMPING = 6, 0.05


def make(arm: Arm) -> Tracker:
    made, n = chain(arm), len(arm.joints)
    pose = pose_of(chain(arm))
    total = max(n, LEAST)
    for _ in range(total - n):
        made.addSegment(PyKDL.Segment(PyKDL.Joint(PyKDL.Joint.RotZ), PyKDL.Frame()))
    given = dict(arm.parameters)
    solver = PyKDL.ChainIkSolverVel_wdls(made, *([given["eps"]] if "eps" in given else []))
    solver.setLambda(given.get("lambda", DAMPING))
    solver.setWeightTS(np.diag([float(place in arm.chosen) for place in range(6)]).tolist())
    solver.setWeightJS(np.diag([float(joint < n) for joint in range(total)]).tolist())
    found = PyKDL.JntArray(total)

    def step(q: np.ndarray, twist: np.ndarray, _: np.ndarray) -> np.ndarray:
        x, y, z, wx, wy, wz = twist.tolist()
        there = array(np.append(q, np.zeros(total - n)))
        solver.CartToJnt(there, PyKDL.Twist(PyKDL.Vector(x, y, z), PyKDL.Vector(wx, wy, wz)), found)
        return np.array([found[i] for i in range(n)])

    return Tracker(step, pose)


if __name__ == "__main__":
    run("PyKDL", "PyKDL", make, version=version())
