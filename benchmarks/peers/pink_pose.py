"""The inverse of a pose by steps of Pink, limits included, restarted where fifty of them do not get there."""

from __future__ import annotations

import argparse

import numpy as np
import pink
import pinocchio as pin
from pink.tasks import FrameTask
from poses import restarted
from timing import System, Work, error, run

STEPS = 50


def make(work: Work, _: argparse.Namespace) -> System:
    model = pin.buildModelFromUrdf(work.urdf)
    configuration = pink.Configuration(model, model.createData(), work.posture)
    limits = (pink.limits.ConfigurationLimit(model, config_limit_gain=1.0),)
    hand = FrameTask(work.tip, position_cost=1.0, orientation_cost=1.0, lm_damping=1e-3)

    def pose(q: np.ndarray) -> np.ndarray:
        configuration.update(q)
        return configuration.get_transform_frame_to_world(work.tip).np

    def attempt(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        hand.set_target(pin.SE3(target))
        configuration.update(np.clip(q, work.lower, work.upper))
        for _ in range(STEPS):
            at = configuration.get_transform_frame_to_world(work.tip).np
            if (error(at, target) < work.tolerance).all():
                break
            velocity = pink.solve_ik(configuration, (hand,), 1.0, solver="daqp", limits=limits)
            configuration.update(np.clip(configuration.q + velocity, work.lower, work.upper))
        return configuration.q.copy()

    return System(restarted(attempt, pose, work), pose)


if __name__ == "__main__":
    run("Pink", "pin-pink", make)
