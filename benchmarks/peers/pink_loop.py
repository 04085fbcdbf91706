"""Pink in closed loop: a frame task for each tool, its own limits from the URDF.

`--lm_damping` is the frame tasks' own, 0 by default and 1 in its arm examples; `--damping` that of the program.
"""

from __future__ import annotations

import argparse

import numpy as np
import pink
import pinocchio as pin
from looping import run
from loops import Loop, Servo, ahead
from pink.tasks import FrameTask


def make(loop: Loop, arguments: argparse.Namespace) -> Servo:
    model = pin.buildModelFromUrdf(loop.urdf)
    assert tuple(model.names)[1:] == loop.joints
    configuration = pink.Configuration(model, model.createData(), loop.q[0])
    lm_damping = float(arguments.lm_damping)
    hands = [FrameTask(tip, position_cost=1.0, orientation_cost=1.0, lm_damping=lm_damping) for tip in loop.tips]
    damping = {} if arguments.damping == "default" else {"damping": float(arguments.damping)}

    def poses(q: np.ndarray) -> np.ndarray:
        configuration.update(q)
        return np.array([configuration.get_transform_frame_to_world(tip).np for tip in loop.tips])

    def step(q: np.ndarray, targets: np.ndarray) -> np.ndarray:
        for hand, near in zip(hands, ahead(loop, poses(q), targets)):
            hand.set_target(pin.SE3(near))
        return pink.solve_ik(configuration, hands, loop.dt, solver="daqp", safety_break=False, **damping)

    return Servo(step, poses)


if __name__ == "__main__":
    run("Pink", "pin-pink", make, lm_damping=("0", "1"), damping=("default", "1e-3"))
