"""The runs in closed loop that all systems get: twelve arms, random starts, random targets; and an everyday case."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

import robust_ik as rik
from benchmarks import chains
from benchmarks.chains import Chain
from benchmarks.environments import CACHE
from benchmarks.peers.loops import Loop

SEED, DT, GAIN = 11, 0.01, 5.0
CAPS = (0.2, 1.0)
"""The tool's greatest speed, m/s and rad/s."""
ARMS = {
    "xarm7": ("xarm7",), "panda": ("panda",), "gen3": ("kinova_gen3",), "ur5": ("ur5",), "ur10": ("ur10",),
    "z1": ("z1",), "so101": ("so101",), "puma560": ("puma560",), "pa10": ("pa10",), "kinova": ("kinova",),
    "iiwa14": ("iiwa14",), "baxter": ("baxter left_gripper", "baxter right_gripper"),
}  # fmt: skip
"""By its name in the tables: a robot that loads by name and its tip, for each of its tools."""


def chain_of(name: str) -> Chain:
    """The chain of an arm by its name, and perhaps a tip."""
    if name == "iiwa14":
        return Chain.of(iiwa14())
    robot, *tip = name.split()
    return Chain.of(rik.load(robot, tip=tip[0]) if tip else rik.load(robot))


def iiwa14() -> rik.Robot:
    """KUKA's LBR iiwa 14 R820 to its flange; lengths, limits and speeds of ROS-Industrial's kuka_lbr_iiwa_support."""
    offsets, twists = (0.36, 0, 0.42, 0, 0.4, 0, 0.126), (-90, 90, 90, -90, -90, 90, 0)
    limits, speeds = (170, 120, 170, 120, 170, 120, 175), (85, 85, 100, 75, 130, 135, 135)
    rows = [
        rik.DHJoint(
            a=0.0, d=d, alpha=math.radians(alpha), lower=-math.radians(limit), upper=math.radians(limit),
            velocity=math.radians(speed), name=f"iiwa_joint_{number}",
        )
        for number, (d, alpha, limit, speed) in enumerate(zip(offsets, twists, limits, speeds), 1)
    ]  # fmt: skip
    return rik.Robot.from_dh(rik.DHTable(rows, "standard", name="iiwa14"))


def bare(name: str) -> tuple[rik.Robot, tuple[Chain, ...], Path]:
    """One of ARMS, read from a URDF of its joints and nothing else, which everyone reads; its chains and that file."""
    made = tuple(map(chain_of, ARMS[name]))
    path = chains.write(CACHE / "loop" / f"{name}.urdf", name, made)
    return rik.load(str(path), tip=made[0].tip, whole_tree=len(made) > 1), made, path


def random_runs(name: str, pairs: int, seconds: float) -> Loop:
    """Starts anywhere within the joint limits, targets where the tools are somewhere else within them.

    More pairs begin with the same ones.
    """
    robot, made, path = bare(name)
    drawn = robot.random(np.random.default_rng(SEED), 2 * pairs)
    tips = tuple(chain.tip for chain in made)
    return loop_of(robot, tips, str(path), drawn[::2], poses(robot, tips, drawn[1::2]), seconds)


def everyday(seconds: float) -> Loop:
    """A Panda, shapes and all, at rest: the hand is to go back by 0.45 m, towards its base, and down by 0.1 m."""
    robot = rik.load("panda")
    tips, q = (str(robot.tip),), robot.rest[None]
    target = poses(robot, tips, q)
    target[..., :3, 3] += (-0.45, 0, -0.1)
    return replace(loop_of(robot, tips, "panda", q, target, seconds), caps=(math.inf, math.inf))


def loop_of(
    robot: rik.Robot, tips: tuple[str, ...], urdf: str, q: np.ndarray, targets: np.ndarray, seconds: float
) -> Loop:
    """What a script reads."""
    return Loop(
        q=q, targets=targets, poses=poses(robot, tips, q), lower=robot.lower, upper=robot.upper,
        speeds=robot.velocity_limit, joints=robot.joint_names, tips=tips, urdf=urdf, dt=DT,
        steps=round(seconds / DT), gain=GAIN, caps=CAPS,
    )  # fmt: skip


def poses(robot: rik.Robot, tips: tuple[str, ...], q: np.ndarray) -> np.ndarray:
    """Where the tools are, (N, k, 4, 4)."""
    return np.stack([robot.pose(q, tip) for tip in tips], axis=1)
