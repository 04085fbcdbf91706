"""One control step of robust_ik, measured as its peers are: same work, same clock, an interpreter of its own."""

from __future__ import annotations

import argparse

import numpy as np
from timing import System, Work, run

import robust_ik as rik

LIMITERS = {"sliding": rik.Sliding(), "saturation": rik.Saturation(), "quadratic_program": rik.QuadraticProgram()}


def make(work: Work, arguments: argparse.Namespace) -> System:
    robot = rik.load(work.urdf, tip=work.tip)
    limiter = LIMITERS[arguments.limiter]
    controller = rik.VelocityController(robot, rik.TaskPriority(rik.JParse(), limiter))  # with the URDF's limits
    gain = 1 / work.dt  # the whole error in one step, as the peers' defaults ask
    posture = rik.PostureTask(work.posture, gain=gain)

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
    run("robust_ik", "robust-ik", make, limiter=tuple(LIMITERS), form=("plain", "prepared"))
