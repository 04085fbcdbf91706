"""mink in closed loop: a frame task for each tool, `ConfigurationLimit` and `VelocityLimit`.

MuJoCo reads the URDF, the same kinematics; it fuses fixed links, and tool frames are sites. Its models have no speed
limits: they come with the runs. `--lm_damping` is the frame tasks' own, 0 by default; `--damping` that of the program.
"""

from __future__ import annotations

import argparse

import mink
import mujoco
import numpy as np
from looping import run
from loops import Loop, Servo, ahead


def make(loop: Loop, arguments: argparse.Namespace) -> Servo:
    spec = mujoco.MjSpec.from_file(loop.urdf)
    for tip in loop.tips:
        spec.body(tip).add_site(name=f"{tip}_site")
    model = spec.compile()
    assert tuple(model.joint(i).name for i in range(model.njnt)) == loop.joints
    configuration = mink.Configuration(model)
    options = {"position_cost": 1.0, "orientation_cost": 1.0, "lm_damping": float(arguments.lm_damping)}
    hands = [mink.FrameTask(frame_name=f"{tip}_site", frame_type="site", **options) for tip in loop.tips]
    limits = (mink.ConfigurationLimit(model), mink.VelocityLimit(model, dict(zip(loop.joints, loop.speeds))))
    damping = {} if arguments.damping == "default" else {"damping": float(arguments.damping)}

    def poses(q: np.ndarray) -> np.ndarray:
        configuration.update(q)
        found = (configuration.get_transform_frame_to_world(f"{tip}_site", "site") for tip in loop.tips)
        return np.array([each.as_matrix() for each in found])

    def step(q: np.ndarray, targets: np.ndarray) -> np.ndarray:
        for hand, near in zip(hands, ahead(loop, poses(q), targets)):
            hand.set_target(mink.SE3.from_matrix(near))
        return mink.solve_ik(configuration, hands, loop.dt, "daqp", limits=limits, **damping)

    return Servo(step, poses)


if __name__ == "__main__":
    run("mink", "mink", make, lm_damping=("0", "1"), damping=("default", "1e-3"))
