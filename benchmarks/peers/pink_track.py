"""Pink along a path: a frame task, its limits from the URDF; `damping` of the program, `lm_damping` of the task."""

from __future__ import annotations

import numpy as np
import pink
import pinocchio as pin
from pink.tasks import FrameTask
from tracking import Arm, Tracker, run


def make(arm: Arm) -> Tracker:
    model = pin.buildModelFromUrdf(arm.urdf)
    assert tuple(model.names)[1:] == arm.joints
    configuration = pink.Configuration(model, model.createData(), pin.neutral(model))
    given = dict(arm.parameters)
    task = {"lm_damping": given.pop("lm_damping")} if "lm_damping" in given else {}
    hand = FrameTask(arm.tip, position_cost=1.0, orientation_cost=float(arm.turns), **task)

    def pose(q: np.ndarray) -> np.ndarray:
        configuration.update(q)
        return configuration.get_transform_frame_to_world(arm.tip).np

    def step(q: np.ndarray, _: np.ndarray, near: np.ndarray) -> np.ndarray:
        configuration.update(q)
        hand.set_target(pin.SE3(near))
        return pink.solve_ik(configuration, [hand], arm.dt, solver="daqp", safety_break=False, **given)

    return Tracker(step, pose)


if __name__ == "__main__":
    run("Pink", "pin-pink", make)
