"""The inverse of a pose by steps of mink, limits included, restarted where fifty of them do not get there."""

from __future__ import annotations

import argparse

import mink
import mujoco
import numpy as np
from poses import restarted
from timing import System, Work, error, run

STEPS = 50


def make(work: Work, _: argparse.Namespace) -> System:
    spec = mujoco.MjSpec.from_file(work.urdf)
    spec.body(work.tip).add_site(name="tool")
    model = spec.compile()
    configuration = mink.Configuration(model)
    hand = mink.FrameTask("tool", "site", position_cost=1.0, orientation_cost=1.0, lm_damping=1e-3)
    limits = (mink.ConfigurationLimit(model, gain=0.95),)

    def pose(q: np.ndarray) -> np.ndarray:
        configuration.update(q)
        return configuration.get_transform_frame_to_world("tool", "site").as_matrix()

    def attempt(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        hand.set_target(mink.SE3.from_matrix(target))
        q = np.clip(q, work.lower, work.upper)
        for _ in range(STEPS):
            if (error(pose(q), target) < work.tolerance).all():
                break
            velocity = mink.solve_ik(configuration, (hand,), 1.0, "daqp", limits=limits)
            q = np.clip(q + velocity, work.lower, work.upper)
        return q

    return System(restarted(attempt, pose, work), pose)


if __name__ == "__main__":
    run("mink", "mink", make)
