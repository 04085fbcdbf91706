"""RoboPlan's OInK along a path: one frame task, its limits; `regularization` of the program, `lm_damping` of the task.

Speed limits come with the scenarios, as its limit is made from numbers.
"""

from __future__ import annotations

import numpy as np
from roboplan.core import CartesianConfiguration, Scene, loadUrdfSceneDescription
from roboplan.optimal_ik import FrameTask, FrameTaskOptions, Oink, PositionLimit, VelocityLimit
from tracking import Arm, Tracker, run


def make(arm: Arm) -> Tracker:
    scene = Scene("arm", loadUrdfSceneDescription(arm.urdf))
    assert tuple(scene.getJointNames()) == arm.joints
    oink = Oink(scene)
    given = dict(arm.parameters)
    task = {"lm_damping": given.pop("lm_damping")} if "lm_damping" in given else {}
    costs = FrameTaskOptions(position_cost=1.0, orientation_cost=float(arm.turns), **task)
    hand = FrameTask(oink, scene, CartesianConfiguration("base", arm.tip, np.eye(4)), costs)
    limits = [PositionLimit(oink), VelocityLimit(oink, arm.dt, arm.speed)]
    moved = np.zeros(oink.num_variables)

    def step(q: np.ndarray, _: np.ndarray, near: np.ndarray) -> np.ndarray:
        hand.setTargetFrameTransform(near)
        oink.solveIk(q, [hand], limits, [], moved, **given)
        return moved / arm.dt

    return Tracker(step, lambda q: scene.forwardKinematics(q, arm.tip))


if __name__ == "__main__":
    run("RoboPlan", "roboplan", make)
