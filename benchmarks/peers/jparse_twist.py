"""One control step of jparse-robotics: its pseudo-inverse with default settings, kinematics by Pinocchio."""

from __future__ import annotations

import argparse

import numpy as np
from jparse_robotics import Robot
from timing import System, Work, run


def make(work: Work, _: argparse.Namespace) -> System:
    robot = Robot.from_urdf(work.urdf, "base", work.tip)

    def step(q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        return np.asarray(robot.jparse(q) @ twist).ravel()

    def pose(q: np.ndarray) -> np.ndarray:
        T = np.eye(4)
        T[:3, 3], T[:3, :3] = robot.forward_kinematics(q)
        return T

    return System(step, pose)


if __name__ == "__main__":
    run("jparse-robotics", "jparse-robotics", make)
