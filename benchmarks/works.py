"""The work that all systems get, always the same for a seed: control steps, and poses to invert."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin

import robust_ik as rik
from benchmarks.chains import Chain
from benchmarks.environments import CACHE
from benchmarks.peers.timing import Work
from robust_ik.robot.reach import find_reach

SEED = 1
TOLERANCE = (1e-4, 1e-3)
"""What counts as solved, m and rad."""
WARM = 0.05  # rad of each joint between the start and a configuration of the target
KINDS = ("random", "warm", "singular", "unreachable 1.1", "unreachable 2")
"""Targets: reachable, from random starts; reachable, from a start nearby; singular; so many times the reach away."""


def arm(name: str) -> tuple[rik.Robot, Chain]:
    """A robot of the catalogue, read from the bare URDF that everyone reads."""
    return bare(Chain.of(rik.load(name)))


def bare(chain: Chain) -> tuple[rik.Robot, Chain]:
    """The robot of a chain, and the chain."""
    return rik.load(str(chain.write(urdf_of(chain))), tip=chain.tip), chain


def urdf_of(chain: Chain) -> Path:
    """Where its URDF is."""
    return CACHE / f"{chain.name}.urdf"


def work_of(
    robot: rik.Robot,
    chain: Chain,
    q: np.ndarray,
    targets: np.ndarray,
    posture: np.ndarray | None = None,
    dt: float = 0.01,
) -> Work:
    """What a script reads, from configurations and targets."""
    return Work(
        q=q, targets=targets, poses=robot.pose(q), posture=robot.rest if posture is None else posture,
        lower=chain.lower, upper=chain.upper, speeds=chain.speeds, placements=chain.placements, tool=chain.tool,
        tolerance=np.array(TOLERANCE), joints=chain.joints, tip=chain.tip, urdf=str(urdf_of(chain)), dt=dt,
    )  # fmt: skip


def twists(robot: rik.Robot, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Configurations anywhere within the limits, and twists of about 0.2 m/s and 0.4 rad/s."""
    rng = np.random.default_rng(SEED)
    return robot.random(rng, count), rng.normal(size=(count, 6)) * np.repeat((0.1, 0.2), 3)


def ahead(poses: np.ndarray, velocities: np.ndarray, dt: float) -> np.ndarray:
    """Where a tool is dt later at these twists, (N, 4, 4): the same task for a system that takes targets only."""
    targets = poses.copy()
    targets[:, :3, 3] += dt * velocities[:, :3]
    targets[:, :3, :3] = np.array([pin.exp3(dt * turn) for turn in velocities[:, 3:]]) @ poses[:, :3, :3]
    return targets


def poses(robot: rik.Robot, kind: str, count: int, seed: int = SEED) -> tuple[np.ndarray, np.ndarray]:
    """Starts and targets of one of KINDS, (count, n) and (count, 4, 4)."""
    rng = np.random.default_rng(seed)
    if kind == "random":
        return robot.random(rng, count), robot.pose(robot.random(rng, count))
    if kind == "warm":
        q = robot.random(rng, count)
        aside = rng.normal(size=q.shape)
        aside *= WARM / np.abs(aside).max(axis=1, keepdims=True)
        return np.clip(q + aside, robot.lower, robot.upper), robot.pose(q)
    if kind == "singular":
        found = singular(robot, rng)
        return robot.random(rng, count), robot.pose(found[rng.integers(len(found), size=count)])
    reach = find_reach(robot)
    targets = robot.pose(robot.random(rng, count))  # any orientation that the tool can have
    aside = rng.normal(size=(count, 3))
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    targets[:, :3, 3] = reach.center + float(kind.split()[1]) * reach.distance * aside
    return robot.random(rng, count), targets


def singular(robot: rik.Robot, rng: np.random.Generator, each: int = 500) -> np.ndarray:
    """Configurations of every family of singularities, those within the limits, (N, n)."""
    atlas = rik.find_singularities(robot)
    found = []
    for leaf in (leaf for row in atlas for leaf in row.leaves):
        values = np.array(leaf.filled(atlas.robot.chain, rng, each if leaf.free else len(leaf.samples)))
        free = list(leaf.free)
        values[:, free] = robot.random(rng, len(values))[:, free]
        found.append(leaf.pinned(values))
    turned = np.concatenate(found)
    turned -= 2 * np.pi * np.round(turned / (2 * np.pi))
    return turned[((turned >= robot.lower) & (turned <= robot.upper)).all(axis=1)]


def pinocchio_pose(robot: rik.Robot) -> Callable[[np.ndarray], np.ndarray]:
    """The tool's poses of configurations (N, n), by Pinocchio and nothing of ours: what judges answers."""
    model, data = robot.model, robot.model.createData()
    frame = model.getFrameId(str(robot.tip))

    def pose(q: np.ndarray) -> np.ndarray:
        result = np.empty((len(q), 4, 4))
        for each, out in zip(q, result):
            pin.framesForwardKinematics(model, data, each)
            out[:] = data.oMf[frame].homogeneous
        return result

    return pose
