"""The inverse of a pose in closed form by EAIK: all solutions, the one within the limits that is nearest to q0."""

from __future__ import annotations

import argparse

import numpy as np
from eaik.IK_HP import HPRobot
from poses import within
from timing import System, Work, error, run


def make(work: Work, _: argparse.Namespace) -> System:
    if len(work.joints) != 6:
        raise SystemExit("closed forms are for six joints")
    frames = [np.eye(4)]
    for placement in work.placements:
        frames.append(frames[-1] @ placement)
    frames.append(frames[-1] @ work.tool)
    axes = np.array([frame[:3, 2] for frame in frames[1:-1]])
    offsets = np.diff([frame[:3, 3] for frame in frames], axis=0)
    arm = HPRobot(axes, offsets)
    if not arm.hasKnownDecomposition():
        raise SystemExit("it knows no closed form for this arm")
    # At zero its tool has the base's axes: what is left is a constant turn of the tool.
    left = np.asarray(arm.fwdKin(np.zeros(6)))[:3, :3].T @ frames[-1][:3, :3]
    turn, back = np.eye(4), np.eye(4)
    turn[:3, :3], back[:3, :3] = left, left.T

    def pose(q: np.ndarray) -> np.ndarray:
        return np.asarray(arm.fwdKin(q)) @ turn

    def step(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        found = [within(each, work) for each in arm.IK(target @ back).Q]
        right = [each for each in found if each is not None and (error(pose(each), target) < work.tolerance).all()]
        return min(right, key=lambda each: np.abs(each - q).max(), default=q)

    return System(step, pose)


if __name__ == "__main__":
    run("EAIK", "EAIK", make)
