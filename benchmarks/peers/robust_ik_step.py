"""One control step of robust_ik, measured as its peers are: same work, same clock, an interpreter of its own.

`--collisions yes`: with a `CollisionLimit` for the pairs beside the URDF.
"""

from __future__ import annotations

import argparse

import numpy as np
from collision_pairs import KeptApart
from timing import System, Work, run

import robust_ik as rik

LIMITERS = {"sliding": rik.Sliding(), "saturation": rik.Saturation(), "quadratic_program": rik.QuadraticProgram()}


def make(work: Work, arguments: argparse.Namespace) -> System:
    robot = rik.load(work.urdf, tip=work.tip)
    method = rik.TaskPriority(rik.JParse(), LIMITERS[arguments.limiter])
    limits: list[rik.Limit] = [rik.JointLimits.of(robot)]
    if arguments.collisions == "yes":
        kept = KeptApart.read(work.urdf)
        apart = {"distance": kept.distance, "influence": kept.influence, "gain": kept.gain}
        limits.append(rik.CollisionLimit.of(robot, pairs=kept.pairs, **apart))
    controller = rik.VelocityController(robot, method, limits)
    gain = 1 / work.dt  # the whole error in one step, as the peers' defaults ask
    posture = rik.PostureTask(work.posture, gain=1.0 if arguments.collisions == "yes" else gain)

    if arguments.form == "prepared":
        loop = rik.ControlLoop(controller, [[rik.FrameTask(np.eye(4), gain=gain)], [posture]], work.dt)
        goal = loop.tasks[0][0].target

        def prepared(q: np.ndarray, target: np.ndarray) -> np.ndarray:
            goal[:] = target
            return loop.step(q)

        return System(prepared, robot.pose)

    def step(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        return controller.step(q, [[rik.FrameTask(target, gain=gain)], [posture]], work.dt).qdot

    return System(step, robot.pose)


if __name__ == "__main__":
    options = {"form": ("plain", "prepared"), "collisions": ("no", "yes")}
    run("robust_ik", "robust-ik", make, limiter=tuple(LIMITERS), **options)
