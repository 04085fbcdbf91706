"""One control step of Pink for two arms: both poses, their relative pose, a posture, its limits from the URDF."""

from __future__ import annotations

import argparse

import numpy as np
import pink
import pinocchio as pin
from loops import Loop, Servo
from pink.tasks import FrameTask, PostureTask, RelativeFrameTask
from stepping import run


def make(loop: Loop, arguments: argparse.Namespace) -> Servo:
    model = pin.buildModelFromUrdf(loop.urdf)
    assert tuple(model.names)[1:] == loop.joints
    configuration = pink.Configuration(model, model.createData(), loop.q[0])
    left, right = loop.tips
    costs = {"position_cost": 1.0, "orientation_cost": 1.0}
    hands = [FrameTask(tip, **costs, lm_damping=1.0) for tip in loop.tips]
    together = RelativeFrameTask(right, left, **costs, lm_damping=1.0)
    posture = PostureTask(cost=1e-3, gain=loop.dt)  # 1/s, as ours
    posture.set_target(loop.q[0])
    tasks = (*hands, together, posture)

    def poses(q: np.ndarray) -> np.ndarray:
        configuration.update(q)
        return np.array([configuration.get_transform_frame_to_world(tip).np for tip in loop.tips])

    def step(q: np.ndarray, targets: np.ndarray) -> np.ndarray:
        configuration.update(q)
        for hand, target in zip(hands, targets):
            hand.set_target(pin.SE3(target))
        together.set_target(pin.SE3(targets[0]).actInv(pin.SE3(targets[1])))
        return pink.solve_ik(configuration, tasks, loop.dt, solver=arguments.solver)

    return Servo(step, poses)


if __name__ == "__main__":
    run("Pink", "pin-pink", make, solver=("daqp", "proxqp", "quadprog"))
