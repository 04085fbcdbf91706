"""EmbodiK along a path: its velocity solver with one frame task, its limits; `damping`, and the σ below which it damps.

That σ is its `tolerance`. Rows that are not controlled are masked; speed limits come with the scenarios.
"""

from __future__ import annotations

import embodik
import numpy as np
from tracking import Arm, Tracker, run


def make(arm: Arm) -> Tracker:
    robot = embodik.RobotModel(arm.urdf)
    assert tuple(robot.get_joint_names()) == arm.joints
    solver = embodik.KinematicsSolver(robot)
    solver.dt = arm.dt
    for name, value in arm.parameters.items():
        getattr(solver, f"set_{name}")(value)
    for joint, speed in enumerate(arm.speed):
        solver.set_joint_velocity_limit(joint, speed)
    hand = solver.add_frame_task("hand", arm.tip)
    hand.priority = 0
    mask = np.array([float(place in arm.chosen) for place in range(6)])
    hand.set_position_mask(mask[:3])
    hand.set_orientation_mask(mask[3:])

    def pose(q: np.ndarray) -> np.ndarray:
        robot.update_configuration(q)
        return robot.get_frame_pose(arm.tip).homogeneous()

    def step(q: np.ndarray, twist: np.ndarray, _: np.ndarray) -> np.ndarray:
        hand.set_target_velocity(twist)
        return solver.solve_velocity_dq(q)

    return Tracker(step, pose)


if __name__ == "__main__":
    run("EmbodiK", "embodik", make)
