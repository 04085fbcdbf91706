"""robust_ik in closed loop, as its peers are run: same starts and targets, an interpreter of its own.

`--collisions yes`: links keep clear of each other as well.
"""

from __future__ import annotations

import argparse

from looping import run
from loops import Loop, Servo
from ours import METHODS, parts, robot_of

import robust_ik as rik


def make(loop: Loop, arguments: argparse.Namespace) -> Servo:
    robot = robot_of(loop)
    assert robot.joint_names == loop.joints
    limits = [rik.JointLimits.of(robot)]
    if arguments.collisions == "yes":
        limits.append(rik.CollisionLimit.of(robot))
    method = METHODS[arguments.method]
    return Servo(*parts(robot, method.resolver, limits, loop, method.below))


if __name__ == "__main__":
    run("robust_ik", "robust-ik", make, method=tuple(METHODS), collisions=("no", "yes"))
