"""The reach of an arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors import TipError
from robust_ik.robot.robot import Robot

_SAMPLES, _STARTS, _ITERATIONS = 500, 12, 200
"""Random configurations, starts of an ascent, steps of each. Five times as many gain at most 10 µm for nine arms."""


@dataclass(frozen=True, eq=False)
class ArmReach:
    """The largest distance found between the tip and the first joint that turns.

    Attributes:
        center: That joint's origin at rest, (3,), m.
        distance: Distance of the tip from it within the joint limits, m: a lower bound, found by ascent.
        q: The configuration at that distance, (nq,).
    """

    center: Array
    distance: float
    q: Array


def find_reach(robot: Robot, rng: np.random.Generator | None = None) -> ArmReach:
    """The reach of the tip, by gradient ascent of the distance from the best of many random configurations.

    Sliding joints without limits keep their sampled position, within 1 m of zero; those of planar and floating joints
    stay at rest, so that the reach is that of what stands on them.

    Args:
        robot: The robot; it must have a tip.
        rng: Source of randomness; by default the same for every call.
    """
    if robot.tip is None:
        raise TipError(f"{robot.name} was loaded whole, without a tip: load it with tip= to ask for its reach")
    rng = np.random.default_rng(0) if rng is None else rng
    center = robot.pose(robot.rest, _first_turning_joint(robot))[:3, 3]
    samples = _standing(robot, robot.random(rng, _SAMPLES))
    order = np.argsort(-np.linalg.norm(robot.pose(samples)[:, :3, 3] - center, axis=-1))
    found = [_ascend(robot, samples[index], center) for index in order[:_STARTS]]
    distance, q = max(found, key=lambda pair: pair[0])
    return ArmReach(center, distance, q)


def _standing(robot: Robot, samples: Array) -> Array:
    """Configurations (N, nq) with the unlimited slides of planar and floating joints at rest."""
    joints = [robot.description.joint[name] for name in robot.joint_names]
    stays = np.array([joint.part_of != "" and joint.kind == "prismatic" for joint in joints]) & np.isinf(robot.lower)
    values = np.where(stays, robot.joint_values(robot.rest), robot.joint_values(samples))
    return samples if not stays.any() else robot.configuration(values)


def _first_turning_joint(robot: Robot) -> str:
    kinds = robot.description.joint
    turning = [name for name in robot.joint_names if kinds[name].kind != "prismatic"]
    return (turning or list(robot.joint_names))[0]


def _ascend(robot: Robot, q: Array, center: Array) -> tuple[float, Array]:
    """Projected gradient ascent of |p(q) − center|; the step grows on success and is halved on failure."""
    sliding_freely = ~np.isfinite(robot.lower) & np.array(
        [robot.description.joint[name].kind == "prismatic" for name in robot.joint_names]
    )
    offset = robot.pose(q)[:3, 3] - center
    distance, step = float(np.linalg.norm(offset)), 0.3
    for _ in range(_ITERATIONS):
        gradient = robot.jacobian(q, rows=("x", "y", "z")).T @ offset
        gradient[sliding_freely] = 0.0
        length = float(np.linalg.norm(gradient))
        if step < 1e-7 or length == 0:
            break
        values = np.clip(robot.joint_values(q) + step * gradient / length, robot.lower, robot.upper)
        trial = robot.configuration(values)
        trial_offset = robot.pose(trial)[:3, 3] - center
        if (trial_distance := float(np.linalg.norm(trial_offset))) > distance:
            q, offset, distance, step = trial, trial_offset, trial_distance, step * 1.5
        else:
            step *= 0.5
    return distance, q
