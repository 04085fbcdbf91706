"""The inverse of a pose by the Robotics Toolbox: `ik_LM`, Chan's damping with k = 0.1, which is its fastest setting."""

from __future__ import annotations

import argparse

import numpy as np
from roboticstoolbox import ET, ETS
from timing import System, Work, run


def make(work: Work, _: argparse.Namespace) -> System:
    parts = []
    for placement, lower, upper in zip(work.placements, work.lower, work.upper):
        parts += [ET.SE3(placement), ET.Rz(qlim=[lower, upper])]
    arm = ETS([*parts, ET.SE3(work.tool)])

    def step(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        return arm.ik_LM(target, q0=q, tol=1e-9, joint_limits=True, k=0.1, method="chan", slimit=100).q

    return System(step, lambda q: np.asarray(arm.fkine(q)))


if __name__ == "__main__":
    run("Robotics Toolbox ik_LM", "roboticstoolbox-python", make)
