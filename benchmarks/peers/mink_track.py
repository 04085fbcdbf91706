"""mink along a path: one frame task, its limits; `damping` of the program, `lm_damping` of the task.

MuJoCo reads the URDF; speed limits come with the scenarios, as its models have none.
"""

from __future__ import annotations

import mink
import mujoco
import numpy as np
from tracking import Arm, Tracker, run


def make(arm: Arm) -> Tracker:
    spec = mujoco.MjSpec.from_file(arm.urdf)
    site = f"{arm.tip}_site"
    spec.body(arm.tip).add_site(name=site)
    model = spec.compile()
    assert tuple(model.joint(i).name for i in range(model.njnt)) == arm.joints
    configuration = mink.Configuration(model)
    given = dict(arm.parameters)
    task = {"lm_damping": given.pop("lm_damping")} if "lm_damping" in given else {}
    costs = {"position_cost": 1.0, "orientation_cost": float(arm.turns)}
    hand = mink.FrameTask(frame_name=site, frame_type="site", **costs, **task)
    limits = (mink.ConfigurationLimit(model), mink.VelocityLimit(model, dict(zip(arm.joints, arm.speed))))

    def pose(q: np.ndarray) -> np.ndarray:
        configuration.update(q)
        return configuration.get_transform_frame_to_world(site, "site").as_matrix()

    def step(q: np.ndarray, _: np.ndarray, near: np.ndarray) -> np.ndarray:
        configuration.update(q)
        hand.set_target(mink.SE3.from_matrix(near))
        return mink.solve_ik(configuration, [hand], arm.dt, "daqp", limits=limits, **given)

    return Tracker(step, pose)


if __name__ == "__main__":
    run("mink", "mink", make)
