"""One control step of PlaCo for two arms: both poses, their relative pose, a posture, both kinds of limits enabled."""

from __future__ import annotations

import argparse

import numpy as np
import placo
from loops import Loop, Servo
from stepping import run

BASE = np.array([0.0, 0, 0, 0, 0, 0, 1])
"""The floating base that every PlaCo robot has: at rest."""


def make(loop: Loop, arguments: argparse.Namespace) -> Servo:  # noqa: ARG001
    robot = placo.RobotWrapper(loop.urdf, placo.Flags.ignore_collisions)
    assert tuple(robot.joint_names()) == loop.joints
    solver = placo.KinematicsSolver(robot)
    solver.mask_fbase(True)
    left, right = loop.tips
    hands = [solver.add_frame_task(tip, np.eye(4)) for tip in loop.tips]
    for tip, hand in zip(loop.tips, hands):
        hand.configure(tip, "soft", 1.0, 1.0)
    together = solver.add_relative_frame_task(left, right, np.eye(4))
    together.configure("together", "soft", 1.0, 1.0)
    posture = solver.add_joints_task()
    posture.set_joints(dict(zip(loop.joints, loop.q[0])))
    posture.configure("posture", "soft", 1e-6)
    solver.enable_joint_limits(True)
    solver.enable_velocity_limits(True)
    solver.dt = loop.dt

    def update(q: np.ndarray) -> None:
        robot.state.q = np.concatenate((BASE, q))
        robot.update_kinematics()

    def poses(q: np.ndarray) -> np.ndarray:
        update(q)
        return np.array([robot.get_T_world_frame(tip) for tip in loop.tips])

    def step(q: np.ndarray, targets: np.ndarray) -> np.ndarray:
        update(q)
        for hand, target in zip(hands, targets):
            hand.T_world_frame = target
        together.T_a_b = np.linalg.solve(targets[0], targets[1])
        return solver.solve(False)[6:] / loop.dt

    return Servo(step, poses)


if __name__ == "__main__":
    run("PlaCo", "placo", make)
