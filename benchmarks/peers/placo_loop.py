"""PlaCo in closed loop: a soft frame task for each tool, joint and velocity limits enabled.

`--regularisation` is the weight of its regularisation task; without one its program has no unique solution where
joints are more than rows, and PlaCo's own examples add one of 1e-4.
"""

from __future__ import annotations

import argparse

import numpy as np
import placo
from looping import run
from loops import Loop, Servo, ahead

BASE = np.array([0.0, 0, 0, 0, 0, 0, 1])
"""The floating base that every PlaCo robot has: at rest."""


def make(loop: Loop, arguments: argparse.Namespace) -> Servo:
    robot = placo.RobotWrapper(loop.urdf, placo.Flags.ignore_collisions)
    assert tuple(robot.joint_names()) == loop.joints
    solver = placo.KinematicsSolver(robot)
    solver.mask_fbase(True)
    hands = [solver.add_frame_task(tip, np.eye(4)) for tip in loop.tips]
    for tip, hand in zip(loop.tips, hands):
        hand.configure(tip, "soft", 1.0, 1.0)
    if arguments.regularisation != "none":
        solver.add_regularization_task(float(arguments.regularisation))
    solver.enable_joint_limits(True)
    solver.enable_velocity_limits(True)
    solver.dt = loop.dt

    def poses(q: np.ndarray) -> np.ndarray:
        robot.state.q = np.concatenate((BASE, q))
        robot.update_kinematics()
        return np.array([robot.get_T_world_frame(tip) for tip in loop.tips])

    def step(q: np.ndarray, targets: np.ndarray) -> np.ndarray:
        for hand, near in zip(hands, ahead(loop, poses(q), targets)):
            hand.T_world_frame = near
        return solver.solve(False)[6:] / loop.dt

    return Servo(step, poses)


if __name__ == "__main__":
    run("PlaCo", "placo", make, regularisation=("none", "1e-4", "1e-3"))
