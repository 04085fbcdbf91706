"""One control step of mink: a weighted quadratic program, with the costs of the tutorial of its documentation.

MuJoCo reads the URDF, the same kinematics; it fuses fixed links, and the tool frame is a site. Its
models have no speed limits: they come with the work. `--plain yes`: the hand task alone, without limits.
"""

from __future__ import annotations

import argparse

import mink
import mujoco
import numpy as np
from timing import System, Work, run


def make(work: Work, arguments: argparse.Namespace) -> System:
    spec = mujoco.MjSpec.from_file(work.urdf)
    spec.body(work.tip).add_site(name="tool")
    model = spec.compile()
    configuration = mink.Configuration(model)
    hand = mink.FrameTask(frame_name="tool", frame_type="site", position_cost=1.0, orientation_cost=1.0)
    posture = mink.PostureTask(model, cost=0.1)
    posture.set_target(work.posture)
    plain = arguments.plain == "yes"
    tasks = (hand,) if plain else (hand, posture)
    limits = (
        ()
        if plain
        else (mink.ConfigurationLimit(model), mink.VelocityLimit(model, dict(zip(work.joints, work.speeds))))
    )

    def step(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        configuration.update(q)
        hand.set_target(mink.SE3.from_matrix(target))
        return mink.solve_ik(configuration, tasks, work.dt, arguments.solver, limits=limits)

    def pose(q: np.ndarray) -> np.ndarray:
        configuration.update(q)
        return configuration.get_transform_frame_to_world("tool", "site").as_matrix()

    return System(step, pose)


if __name__ == "__main__":
    run("mink", "mink", make, solver=("daqp", "proxqp", "quadprog"), plain=("no", "yes"))
