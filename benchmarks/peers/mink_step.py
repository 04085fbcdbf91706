"""One control step of mink: a weighted quadratic program, with the costs of the tutorial of its documentation.

MuJoCo reads the URDF, the same kinematics; it fuses fixed links, and the tool frame is a site. Its
models have no speed limits: they come with the work. `--plain yes`: the hand task alone, without limits.
`--collisions yes`: a `CollisionAvoidanceLimit` for the pairs beside the URDF, with its default gain.
"""

from __future__ import annotations

import argparse

import mink
import mujoco
import numpy as np
from collision_pairs import KeptApart
from timing import System, Work, run


def make(work: Work, arguments: argparse.Namespace) -> System:
    spec = mujoco.MjSpec.from_file(work.urdf)
    spec.body(work.tip).add_site(name="tool")
    groups = named_shapes(spec, work.urdf) if arguments.collisions == "yes" else []
    model = spec.compile()
    configuration = mink.Configuration(model)
    hand = mink.FrameTask(frame_name="tool", frame_type="site", position_cost=1.0, orientation_cost=1.0)
    easy = {} if arguments.collisions == "no" else {"gain": work.dt}  # 1/s, as ours
    posture = mink.PostureTask(model, cost=0.1, **easy)
    posture.set_target(work.posture)
    plain = arguments.plain == "yes"
    tasks = (hand,) if plain else (hand, posture)
    limits: list[mink.Limit] = []
    if not plain:
        limits += [mink.ConfigurationLimit(model), mink.VelocityLimit(model, dict(zip(work.joints, work.speeds)))]
    if groups:
        kept = KeptApart.read(work.urdf)
        near = {
            "minimum_distance_from_collisions": kept.distance,
            "collision_detection_distance": kept.influence,
        }
        limits.append(mink.CollisionAvoidanceLimit(model, groups, **near))

    def step(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        configuration.update(q)
        hand.set_target(mink.SE3.from_matrix(target))
        return mink.solve_ik(configuration, tasks, work.dt, arguments.solver, limits=limits)

    def pose(q: np.ndarray) -> np.ndarray:
        configuration.update(q)
        return configuration.get_transform_frame_to_world("tool", "site").as_matrix()

    return System(step, pose)


def named_shapes(spec: mujoco.MjSpec, urdf: str) -> list[tuple[list[str], list[str]]]:
    """Names the shapes of links, which no longer fuse, and gives those of the pairs that are kept apart."""
    spec.compiler.fusestatic = False
    of_link: dict[str, list[str]] = {}
    for body in spec.bodies:
        for number, geom in enumerate(body.geoms):
            geom.name = f"{body.name}_{number}"
            of_link.setdefault(body.name, []).append(geom.name)
    return [(of_link[first], of_link[second]) for first, second in KeptApart.read(urdf).pairs]


if __name__ == "__main__":
    options = {"plain": ("no", "yes"), "collisions": ("no", "yes")}
    run("mink", "mink", make, solver=("daqp", "proxqp", "quadprog"), **options)
