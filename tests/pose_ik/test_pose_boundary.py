"""Configurations on the boundary of what is reachable: what the table of starts holds of them, and their use."""

import numpy as np
import pinocchio as pin
import pytest

import robust_ik as rik
from robust_ik.kernels.pose import pose_layout as lay
from tests import pinocchio_reference

OFFSET = ("panda", "xarm7")
"""Arms whose solutions on the boundary are isolated."""
OTHERS = ("ur5", "pa10", "puma560", "kinova_gen3", "srs_10r", "talos_arm")


def boundary(robot):
    """Configurations, (N, n), and outward normals, (N, 5), of a robot all of whose joints move the tip."""
    problem = robot.pose_solver().problem
    table = problem[int(problem[lay.TABLE]) :].reshape(-1, lay.ENTRIES)
    chosen = slice(lay.MOST_SEEDS, lay.MOST_SEEDS + int(problem[lay.EDGES]))
    return table[lay.FEATURES : lay.FEATURES + robot.n, chosen].T, table[lay.NORMAL : lay.NORMAL + 5, chosen].T


def reduced(robot, q):
    """Radius, height and axis of the last joint, turned so that its origin is ahead, (..., 5)."""
    chain = robot.chain()
    G = robot.pose(q) @ np.linalg.inv(chain.tip)
    p, a = ((G[..., :3, i] - origin) @ chain.rotations[0] for i, origin in ((3, chain.origins[0]), (2, 0.0)))
    radius = np.hypot(p[..., 0], p[..., 1])
    ahead = p[..., :2] / radius[..., None]
    along = (a[..., :2] * ahead).sum(axis=-1)
    return np.stack(
        [radius, p[..., 2], along, a[..., 1] * ahead[..., 0] - a[..., 0] * ahead[..., 1], a[..., 2]], axis=-1
    )


@pytest.mark.parametrize("name", OFFSET)
def test_boundary_configurations_are_singular_and_inside_limits(name, rng):
    robot = rik.load(name)
    q, _ = boundary(robot)
    assert len(q) > 50
    q = q.copy()
    q[:, [0, -1]] = robot.random(rng, len(q))[:, [0, -1]]
    assert ((q >= robot.lower) & (q <= robot.upper)).all()
    sigma = np.linalg.svd(
        np.array([pinocchio_reference.jacobian(robot, each, robot.tip, "local_world_aligned") for each in q]),
        compute_uv=False,
    )
    assert sigma[:, -1].max() < 1e-5


@pytest.mark.parametrize("name", OFFSET)
def test_no_joint_moves_the_pose_along_a_normal(name, rng):
    robot = rik.load(name)
    q, normal = boundary(robot)
    assert np.linalg.norm(normal, axis=1).min() > 0.1
    for size in (1e-3, 1e-5):
        aside = size * rng.normal(size=q.shape)
        moved = reduced(robot, q + aside) - reduced(robot, q)
        assert np.abs((normal * moved).sum(axis=1)).max() < 300 * size**2
        assert np.linalg.norm(moved, axis=1).max() > 0.1 * size
    inwards = reduced(robot, robot.random(rng, 500)) - reduced(robot, q)[:, None]
    assert np.median((normal[:, None] * inwards).sum(axis=-1)) < 0


@pytest.mark.parametrize("name", OFFSET)
def test_poses_a_little_farther_out_are_out_of_reach(name):
    robot = rik.load(name)
    q, _ = boundary(robot)
    T = robot.pose(q)
    u = np.linalg.svd(robot.jacobian(q))[0][:, :, -1]
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    missed = []
    for sign in (-1, 1):
        there = T.copy()
        there[:, :3, 3] += 0.02 * sign * u[:, :3]
        there[:, :3, :3] = np.array([pin.exp3(0.02 * sign * each) for each in u[:, 3:]]) @ there[:, :3, :3]
        missed.append(~robot.solve_poses(there, q0=q).solved)
    assert (missed[0] | missed[1]).mean() > 0.8
    assert (missed[0] & missed[1]).mean() < 0.1


def test_targets_on_the_boundary_take_few_steps(rng):
    robot = rik.load("panda")
    own = boundary(robot)[0]
    q = robot.random(rng, 1000)
    q[:, 3:5] = own[0, 3:5]
    assert np.abs(own[:, 3:5] - own[0, 3:5]).max() < 1e-5
    q0 = robot.random(rng, len(q))
    found, usual = (
        robot.solve_poses(robot.pose(q), q0=q0),
        robot.solve_poses(robot.pose(robot.random(rng, 1000)), q0=q0),
    )
    found.raise_for_status()
    assert found.iterations.mean() < 4 * usual.iterations.mean()
    assert np.median(found.iterations) < 2 * np.median(usual.iterations)


@pytest.mark.parametrize("name", OTHERS)
def test_arms_with_six_joints_or_with_motion_on_the_boundary_need_none(name):
    assert len(boundary(rik.load(name))[0]) == 0
