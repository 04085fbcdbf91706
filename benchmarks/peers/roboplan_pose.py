"""The inverse of a pose by RoboPlan's SimpleIk, without collisions; its restarts, and ours where it gives up."""

from __future__ import annotations

import argparse

import numpy as np
from poses import restarted
from roboplan.core import CartesianConfiguration, JointConfiguration, Scene, loadUrdfSceneDescription
from roboplan.simple_ik import SimpleIk, SimpleIkOptions
from timing import System, Work, run


def make(work: Work, _: argparse.Namespace) -> System:
    scene = Scene("arm", loadUrdfSceneDescription(work.urdf))
    scene.addGroup("arm", list(work.joints))
    metres, radians = work.tolerance
    solver = SimpleIk(
        scene,
        SimpleIkOptions(
            group_name="arm", max_iters=200, step_size=1.0, damping=1e-3, check_collisions=False,
            max_linear_error_norm=float(metres), max_angular_error_norm=float(radians),
        ),
    )  # fmt: skip
    names = list(work.joints)

    def attempt(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        solution = JointConfiguration(names, q)
        solver.solveIk(CartesianConfiguration("base", work.tip, target), JointConfiguration(names, q), solution)
        return np.array(solution.positions)

    def pose(q: np.ndarray) -> np.ndarray:
        return scene.forwardKinematics(q, work.tip)

    return System(restarted(attempt, pose, work), pose)


if __name__ == "__main__":
    run("RoboPlan SimpleIk", "roboplan", make)
