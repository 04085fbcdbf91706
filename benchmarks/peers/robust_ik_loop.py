"""robust_ik in closed loop, as its peers are run: same starts and targets, an interpreter of its own.

`--collisions yes`: links keep clear of each other as well.
"""

from __future__ import annotations

import argparse

import numpy as np
from looping import run
from loops import Loop, Servo
from ours import METHODS

import robust_ik as rik


def make(loop: Loop, arguments: argparse.Namespace) -> Servo:
    robot = rik.load(loop.urdf, tip=loop.tips[0], whole_tree=len(loop.tips) > 1)
    assert robot.joint_names == loop.joints
    limits = [rik.JointLimits.of(robot)]
    if arguments.collisions == "yes":
        limits.append(rik.CollisionLimit.of(robot))
    controller = rik.VelocityController(robot, METHODS[arguments.method], limits)
    caps = {"max_linear": loop.caps[0] / loop.gain, "max_angular": loop.caps[1] / loop.gain}

    def step(q: np.ndarray, targets: np.ndarray) -> np.ndarray:
        hands = [rik.FrameTask(target, loop.gain, frame=tip, **caps) for target, tip in zip(targets, loop.tips)]
        return controller.step(q, [hands], loop.dt).qdot

    def poses(q: np.ndarray) -> np.ndarray:
        return np.array([robot.pose(q, tip) for tip in loop.tips])

    return Servo(step, poses, controller.reset)


if __name__ == "__main__":
    run("robust_ik", "robust-ik", make, method=tuple(METHODS), collisions=("no", "yes"))
