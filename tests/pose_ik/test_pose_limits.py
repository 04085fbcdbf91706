"""Poses whose configurations have joints exactly at limits, and the nearest poses of what is out of reach."""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_array_less

import robust_ik as rik
from robust_ik.robot.reach import find_reach
from tests.arms import arm_of

# KUKA KR 210 L150, from its public description; and a small arm whose lengths were rounded at 1e-6 m.
KR210 = [
    ("-0.00262 0.00097586 0.33099", "0 0 0", "0 0 1", -3.228859205, 3.228859205),
    ("0.35277 -0.037476 0.4192", "0 0 0", "0 1 0", -0.785398185, 1.483529905),
    ("-9.8483E-05 -0.1475 1.2499", "0 0 0", "0 1 0", -3.66519153, 1.134464045),
    ("0.95795 0.184 -0.055059", "0 0 0", "1 0 0", -6.10865255, 6.10865255),
    ("0.542 0 0", "0 0 0", "0 1 0", -2.181661625, 2.181661625),
    ("0.1925 0 0", "0 0 0", "1 0 0", -6.10865255, 6.10865255),
]
ROUNDED = [
    ("0 -0.0039812 0.09125", "0 0 1.5708", "0 0 1", -2.7475, 2.7475),
    ("0.0039812 0 0.0425", "1.5708 0 -1.5708", "0 0 1", -3.14, 0.0),
    ("-0.28184 0.040424 0", "0 0 0", "0 0 -1", -3.14, 0.0),
    ("0.10092 0.028546 0.0036562", "-1.5708 0 -1.5708", "0 0 1", -2.79, 2.79),
    ("0 0.0036562 0.1365", "1.5708 0 0", "0 0 1", -1.57, 1.57),
    ("0 0.091 0.0036563", "-1.5708 0 0", "0 0 1", -2.791, 2.791),
]
TOOLS = {"kr210": (KR210, "0.0375 0 -0.00023924"), "rounded": (ROUNDED, "0 0 0")}


@cache
def arm(name):
    return arm_of(*TOOLS[name]) if name in TOOLS else rik.load(name)


def at_limits(robot, rng, count, share):
    """Configurations with this share of the joints exactly at a limit, (count, nq)."""
    lower = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    upper = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    values, shape = rng.uniform(lower, upper, (count, robot.n)), (count, robot.n)
    limits = np.where(rng.random(shape) < 0.5, lower, upper)
    return robot.configuration(np.where(rng.random(shape) < share, limits, values))


@pytest.mark.parametrize(
    ("name", "count"), [("kr210", 12000), ("rounded", 6000), ("panda", 2000), ("ur5_limited", 2000), ("pa10", 2000)]
)
def test_no_target_is_missed_whose_joints_are_at_limits(name, count, rng):
    robot = arm(name)
    T = robot.pose(at_limits(robot, rng, count, 0.5))
    found = robot.solve_poses(T, robot.random(rng, count))
    assert found.solved.all()
    assert ((found.q >= robot.lower) & (found.q <= robot.upper)).all()


@pytest.mark.parametrize("name", ["kr210", "rounded"])
def test_nor_where_all_of_them_are(name, rng):
    robot = arm(name)
    found = robot.solve_poses(robot.pose(at_limits(robot, rng, 2000, 1.0)))
    assert found.solved.all()


def test_configurations_found_without_limits_are_brought_inside_them(rng):
    robot = arm("kr210")
    T = robot.pose(at_limits(robot, rng, 300, 0.5))
    found = robot.solve_poses(T, prefer="any", solutions=4)
    kept = np.isfinite(found.solutions).all(axis=-1)
    inside = ((found.solutions >= robot.lower) & (found.solutions <= robot.upper)).all(axis=-1)
    assert inside[kept].all()
    assert (found.found >= 1).all()


def pushed(robot, rng, count):
    """Poses from 1.05 to 2 times the reach away."""
    reach, away = find_reach(robot), rng.normal(size=(count, 3))
    T = robot.pose(robot.random(rng, count))
    far = reach.distance * rng.uniform(1.05, 2.0, count) / np.linalg.norm(away, axis=1)
    T[:, :3, 3] = reach.center + far[:, None] * away
    return T


def beyond(robot, rng, count):
    """Poses of configurations up to 0.6 rad beyond the limits."""
    lower, upper = np.maximum(robot.lower - 0.6, -2 * np.pi), np.minimum(robot.upper + 0.6, 2 * np.pi)
    return robot.pose(robot.configuration(rng.uniform(lower, upper, (count, robot.n))))


def left(found):
    return np.hypot(*np.moveaxis(found.error, -1, 0))


@pytest.mark.parametrize(("name", "targets"), [("ur5", pushed), ("panda", pushed), ("kr210", beyond)])
def test_the_nearest_pose_is_within_one_percent_of_the_best_that_much_effort_finds(name, targets, rng):
    robot = arm(name)
    T = targets(robot, rng, 80)
    best = np.min(
        [left(robot.solve_poses(T, robot.random(rng, 80), effort="thorough", prefer="any")) for _ in range(2)], axis=0
    )
    assert_array_less(left(robot.solve_poses(T)), 1.01 * best + 2e-8)
