"""One control step of EmbodiK: its velocity solver with one frame task, without limits; damped, as it comes."""

from __future__ import annotations

import argparse

import embodik
import numpy as np
from timing import System, Work, run


def make(work: Work, _: argparse.Namespace) -> System:
    robot = embodik.RobotModel(work.urdf)
    solver = embodik.KinematicsSolver(robot)
    solver.dt = work.dt
    hand = solver.add_frame_task("hand", work.tip)
    hand.priority = 0

    def step(q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        hand.set_target_velocity(twist)
        return solver.solve_velocity_dq(q, False)

    def pose(q: np.ndarray) -> np.ndarray:
        robot.update_configuration(q)
        return robot.get_frame_pose(work.tip).homogeneous()

    return System(step, pose)


if __name__ == "__main__":
    run("EmbodiK", "embodik", make)
