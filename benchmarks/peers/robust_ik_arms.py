"""One control step of robust_ik for two arms: their relative pose first, both poses second, the posture third."""

from __future__ import annotations

import argparse

import numpy as np
from loops import Loop, Servo
from stepping import run

import robust_ik as rik


def make(loop: Loop, arguments: argparse.Namespace) -> Servo:
    robot = rik.load(loop.urdf, whole_tree=True)
    assert robot.joint_names == loop.joints
    (left, right), gain = loop.tips, 1 / loop.dt  # the whole way in one step, as the peers' defaults ask
    controller = rik.VelocityController(robot)  # with the URDF's limits
    posture = rik.PostureTask(loop.q[0])

    def stack(targets: np.ndarray) -> list[list[rik.Task]]:
        relative = np.linalg.solve(targets[0], targets[1])
        hands = [rik.FrameTask(target, gain, frame=tip) for target, tip in zip(targets, loop.tips)]
        return [[rik.RelativeTask(right, left, relative, gain)], hands, [posture]]

    def poses(q: np.ndarray) -> np.ndarray:
        return np.array([robot.pose(q, tip) for tip in loop.tips])

    if arguments.form == "plain":
        return Servo(lambda q, targets: controller.step(q, stack(targets), loop.dt).qdot, poses)
    prepared = rik.ControlLoop(controller, stack(loop.poses[0]), loop.dt)
    (together,), hands, _ = prepared.tasks
    goals = [hand.target for hand in hands]

    def step(q: np.ndarray, targets: np.ndarray) -> np.ndarray:
        together.target[:] = np.linalg.solve(targets[0], targets[1])
        goals[0][:], goals[1][:] = targets
        return prepared.step(q)

    return Servo(step, poses)


if __name__ == "__main__":
    run("robust_ik", "robust-ik", make, form=("plain", "prepared"))
