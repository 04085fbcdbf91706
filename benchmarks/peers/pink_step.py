"""One control step of Pink: a weighted quadratic program, with the costs of the Panda example of its documentation.

`--plain yes`: the hand task alone, without limits. `--collisions`: a `SelfCollisionBarrier` for all pairs beside the
URDF, or for as many of them as said, the nearest; meshes are made convex first, as the barrier's documentation asks.
"""

from __future__ import annotations

import argparse

import numpy as np
import pink
import pinocchio as pin
from collision_pairs import KeptApart
from pink.barriers import SelfCollisionBarrier
from pink.tasks import FrameTask, PostureTask
from timing import System, Work, run


def make(work: Work, arguments: argparse.Namespace) -> System:
    model = pin.buildModelFromUrdf(work.urdf)
    solids, barriers, solver = {}, [], {"solver": arguments.solver}
    if arguments.collisions != "no":
        kept = KeptApart.read(work.urdf)
        solids = shapes(model, work.urdf, kept)
        count = len(solids["collision_model"].collisionPairs)
        nearest = count if arguments.collisions == "all" else min(count, int(arguments.collisions))
        barriers = [SelfCollisionBarrier(n_collision_pairs=nearest, gain=kept.gain, d_min=kept.distance)]
    configuration = pink.Configuration(model, model.createData(), work.posture, **solids)
    hand = FrameTask(work.tip, position_cost=1.0, orientation_cost=1.0, lm_damping=1.0)
    easy = {} if arguments.collisions == "no" else {"gain": work.dt}  # 1/s, as ours
    posture = PostureTask(cost=1e-3, **easy)
    posture.set_target(work.posture)
    plain = arguments.plain == "yes"
    tasks = (hand,) if plain else (hand, posture)
    limits = () if plain else None  # None: those of the URDF

    def step(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        configuration.update(q)
        hand.set_target(pin.SE3(target))
        return pink.solve_ik(configuration, tasks, work.dt, **solver, limits=limits, barriers=barriers)

    def pose(q: np.ndarray) -> np.ndarray:
        configuration.update(q)
        return configuration.get_transform_frame_to_world(work.tip).np

    return System(step, pose)


def shapes(model: pin.Model, urdf: str, kept: KeptApart) -> dict[str, object]:
    """The collision model with the pairs that are kept apart, and its data."""
    made = pin.buildGeomFromUrdf(model, urdf, pin.GeometryType.COLLISION)
    of_link: dict[str, list[int]] = {}
    for index, each in enumerate(made.geometryObjects):
        if isinstance(each.geometry, pin.coal.BVHModelBase):
            each.geometry.buildConvexRepresentation(False)
            each.geometry = each.geometry.convex
        of_link.setdefault(model.frames[each.parentFrame].name, []).append(index)
    for a, b in ((i, j) for first, second in kept.pairs for i in of_link[first] for j in of_link[second]):
        made.addCollisionPair(pin.CollisionPair(a, b))
    data = pin.GeometryData(made)
    data.enable_contact = True  # as `pink.utils.process_collision_pairs` has it
    return {"collision_model": made, "collision_data": data}


if __name__ == "__main__":
    options = {"plain": ("no", "yes"), "collisions": ("no", "all", "8")}
    run("Pink", "pin-pink", make, solver=("daqp", "proxqp", "quadprog"), **options)
