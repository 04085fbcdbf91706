"""The inverse of a pose by EmbodiK's position solver, restarted until an answer is right and within the limits."""

from __future__ import annotations

import argparse

import embodik
import numpy as np
from poses import restarted
from timing import System, Work, run


def make(work: Work, _: argparse.Namespace) -> System:
    robot = embodik.RobotModel(work.urdf)
    solver = embodik.KinematicsSolver(robot)
    options = embodik.PositionIKOptions()
    # With its default step of 10 ms it takes ten times as many; with 1 s it does not converge.
    options.dt, options.max_iterations = 0.1, 200
    options.position_tolerance, options.orientation_tolerance = work.tolerance.tolist()

    def attempt(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        return np.array(solver.solve_position(q, target, work.tip, options).q_solution)

    def pose(q: np.ndarray) -> np.ndarray:
        robot.update_configuration(q)
        return robot.get_frame_pose(work.tip).homogeneous()

    return System(restarted(attempt, pose, work), pose)


if __name__ == "__main__":
    run("EmbodiK", "embodik", make)
