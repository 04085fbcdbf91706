"""PlaCo along a path: one soft frame or position task, its limits; `regularisation` is that task's weight.

Its examples add one of 1e-4 or less, and without one its program has no unique solution for redundant arms: the
default here is 1e-4.
"""

from __future__ import annotations

import numpy as np
import placo
from placo_loop import BASE
from tracking import Arm, Tracker, run


def make(arm: Arm) -> Tracker:
    robot = placo.RobotWrapper(arm.urdf, placo.Flags.ignore_collisions)
    assert tuple(robot.joint_names()) == arm.joints
    solver = placo.KinematicsSolver(robot)
    solver.mask_fbase(True)
    hand = solver.add_frame_task(arm.tip, np.eye(4)) if arm.turns else solver.add_position_task(arm.tip, np.zeros(3))
    hand.configure(arm.tip, "soft", *((1.0, 1.0) if arm.turns else (1.0,)))
    solver.add_regularization_task(arm.parameters.get("regularisation", 1e-4))
    solver.enable_joint_limits(True)
    solver.enable_velocity_limits(True)
    solver.dt = arm.dt

    def pose(q: np.ndarray) -> np.ndarray:
        robot.state.q = np.concatenate((BASE, q))
        robot.update_kinematics()
        return robot.get_T_world_frame(arm.tip)

    def step(q: np.ndarray, _: np.ndarray, near: np.ndarray) -> np.ndarray:
        pose(q)
        if arm.turns:
            hand.T_world_frame = near
        else:
            hand.target_world = near[:3, 3]
        return solver.solve(False)[6:] / arm.dt

    return Tracker(step, pose)


if __name__ == "__main__":
    run("PlaCo", "placo", make)
