"""One control step of mink for two arms: both poses, their relative pose, a posture, its limits.

MuJoCo reads the URDF, as in `mink_step.py`.
"""

from __future__ import annotations

import argparse

import mink
import mujoco
import numpy as np
from loops import Loop, Servo
from stepping import run


def make(loop: Loop, arguments: argparse.Namespace) -> Servo:
    spec = mujoco.MjSpec.from_file(loop.urdf)
    for tip in loop.tips:
        spec.body(tip).add_site(name=f"{tip}_site")
    model = spec.compile()
    assert tuple(model.joint(i).name for i in range(model.njnt)) == loop.joints
    configuration = mink.Configuration(model)
    left, right = (f"{tip}_site" for tip in loop.tips)
    costs = {"position_cost": 1.0, "orientation_cost": 1.0}
    hands = [mink.FrameTask(frame_name=site, frame_type="site", **costs) for site in (left, right)]
    together = mink.RelativeFrameTask(right, "site", left, "site", **costs)
    posture = mink.PostureTask(model, cost=0.1, gain=loop.dt)  # 1/s, as ours
    posture.set_target(loop.q[0])
    tasks = (*hands, together, posture)
    limits = (mink.ConfigurationLimit(model), mink.VelocityLimit(model, dict(zip(loop.joints, loop.speeds))))

    def poses(q: np.ndarray) -> np.ndarray:
        configuration.update(q)
        found = (configuration.get_transform_frame_to_world(site, "site") for site in (left, right))
        return np.array([each.as_matrix() for each in found])

    def step(q: np.ndarray, targets: np.ndarray) -> np.ndarray:
        configuration.update(q)
        wanted = [mink.SE3.from_matrix(target) for target in targets]
        for hand, target in zip(hands, wanted):
            hand.set_target(target)
        together.set_target(wanted[0].inverse() @ wanted[1])
        return mink.solve_ik(configuration, tasks, loop.dt, arguments.solver, limits=limits)

    return Servo(step, poses)


if __name__ == "__main__":
    run("mink", "mink", make, solver=("daqp", "proxqp", "quadprog"))
