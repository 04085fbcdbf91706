"""One control step of Pink: a weighted quadratic program, with the costs of the Panda example of its documentation.

`--plain yes`: the hand task alone, without limits.
"""

from __future__ import annotations

import argparse

import numpy as np
import pink
import pinocchio as pin
from pink.tasks import FrameTask, PostureTask
from timing import System, Work, run


def make(work: Work, arguments: argparse.Namespace) -> System:
    model = pin.buildModelFromUrdf(work.urdf)
    configuration = pink.Configuration(model, model.createData(), work.posture)
    hand = FrameTask(work.tip, position_cost=1.0, orientation_cost=1.0, lm_damping=1.0)
    posture = PostureTask(cost=1e-3)
    posture.set_target(work.posture)
    plain = arguments.plain == "yes"
    tasks = (hand,) if plain else (hand, posture)
    limits = () if plain else None  # None: those of the URDF

    def step(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        configuration.update(q)
        hand.set_target(pin.SE3(target))
        return pink.solve_ik(configuration, tasks, work.dt, solver=arguments.solver, limits=limits)

    def pose(q: np.ndarray) -> np.ndarray:
        configuration.update(q)
        return configuration.get_transform_frame_to_world(work.tip).np

    return System(step, pose)


if __name__ == "__main__":
    run("Pink", "pin-pink", make, solver=("daqp", "proxqp", "quadprog"), plain=("no", "yes"))
