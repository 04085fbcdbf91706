"""One control step of RoboPlan's OInK: a quadratic program in C++; the hand task alone, without limits."""

from __future__ import annotations

import argparse

import numpy as np
from roboplan.core import CartesianConfiguration, Scene, loadUrdfSceneDescription
from roboplan.optimal_ik import FrameTask, FrameTaskOptions, Oink
from timing import System, Work, run


def make(work: Work, _: argparse.Namespace) -> System:
    scene = Scene("arm", loadUrdfSceneDescription(work.urdf))
    oink = Oink(scene)
    goal = CartesianConfiguration("base", work.tip, np.eye(4))
    hand = FrameTask(oink, scene, goal, FrameTaskOptions(1.0, 1.0))
    moved = np.zeros(oink.num_variables)

    def step(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        hand.setTargetFrameTransform(target)
        oink.solveIk(q, [hand], [], [], moved)
        return moved / work.dt

    return System(step, lambda q: scene.forwardKinematics(q, work.tip))


if __name__ == "__main__":
    run("RoboPlan", "roboplan", make)
