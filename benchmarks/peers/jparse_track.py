"""jparse-robotics along a path: its pseudo-inverse of its own Jacobian; `gamma` is its threshold."""

from __future__ import annotations

import numpy as np
from jparse_robotics import JParseCore, Robot
from tracking import Arm, Tracker, run


def make(arm: Arm) -> Tracker:
    robot = Robot.from_urdf(arm.urdf, "base", arm.tip)
    core = JParseCore(**arm.parameters)

    def pose(q: np.ndarray) -> np.ndarray:
        T = np.eye(4)
        T[:3, 3], T[:3, :3] = robot.forward_kinematics(q)
        return T

    def step(q: np.ndarray, twist: np.ndarray, _: np.ndarray) -> np.ndarray:
        return np.asarray(core.compute(robot.jacobian(q)[arm.chosen]) @ twist[arm.chosen]).ravel()

    return Tracker(step, pose)


if __name__ == "__main__":
    run("jparse-robotics", "jparse-robotics", make)
