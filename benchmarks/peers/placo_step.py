"""One control step of PlaCo: a quadratic program in C++, as the getting-started page of its documentation sets it up.

`--priority soft` weighs the hand task against the posture; `scaled` makes it an equality whose right side is scaled
down as little as the limits demand. `--plain yes`: the hand task alone, without limits.
`--collisions yes`: its constraint that avoids self-collisions, for the pairs beside the URDF; meshes stay triangles.
"""

from __future__ import annotations

import argparse
import json
import tempfile

import numpy as np
import placo
from collision_pairs import KeptApart
from timing import System, Work, run

BASE = np.array([0.0, 0, 0, 0, 0, 0, 1])
"""The floating base that every PlaCo robot has: at rest."""


def make(work: Work, arguments: argparse.Namespace) -> System:
    avoid = arguments.collisions == "yes"
    robot = placo.RobotWrapper(work.urdf) if avoid else placo.RobotWrapper(work.urdf, placo.Flags.ignore_collisions)
    assert tuple(robot.joint_names()) == work.joints
    solver = placo.KinematicsSolver(robot)
    solver.mask_fbase(True)
    hand = solver.add_frame_task(work.tip, np.eye(4))
    hand.configure("hand", arguments.priority, 1.0, 1.0)
    plain = arguments.plain == "yes"
    if not plain:
        posture = solver.add_joints_task()
        posture.set_joints(dict(zip(work.joints, work.posture)))
        posture.configure("posture", "soft", 1e-6)
    solver.enable_joint_limits(not plain)
    solver.enable_velocity_limits(not plain)
    solver.dt = work.dt
    if avoid:
        kept = KeptApart.read(work.urdf)
        load_pairs(robot, kept)
        apart = solver.add_avoid_self_collisions_constraint()
        apart.self_collisions_margin, apart.self_collisions_trigger = kept.distance, kept.influence

    def update(q: np.ndarray) -> None:
        robot.state.q = np.concatenate((BASE, q))
        robot.update_kinematics()

    def step(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        update(q)
        hand.T_world_frame = target
        return solver.solve(False)[6:] / work.dt

    def pose(q: np.ndarray) -> np.ndarray:
        update(q)
        return robot.get_T_world_frame(work.tip)

    return System(step, pose)


def load_pairs(robot: placo.RobotWrapper, kept: KeptApart) -> None:
    """Has a robot keep those pairs of its links apart, and no others: a shape is called as its link, with a number."""
    of_link: dict[str, list[int]] = {}
    for index, shape in enumerate(robot.collision_model.geometryObjects):
        of_link.setdefault(shape.name.rpartition("_")[0], []).append(index)
    pairs = [(i, j) for first, second in kept.pairs for i in of_link[first] for j in of_link[second]]
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(pairs, file)
        file.flush()
        robot.load_collision_pairs(file.name)


if __name__ == "__main__":
    options = {"plain": ("no", "yes"), "collisions": ("no", "yes")}
    run("PlaCo", "placo", make, priority=("soft", "scaled"), **options)
