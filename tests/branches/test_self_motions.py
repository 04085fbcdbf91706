"""Self-motions of arms with a joint too many: curves that keep the pose, as many as there are, within limits."""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from tests import dh_arms
from tests.branches.test_all_solutions import apart, holds, misses

ARMS = ("pa10", "srs_7r", "panda", "kinova_gen3", "xarm7")


@cache
def arm(name):
    return rik.load(name)


@pytest.mark.parametrize("name", ARMS)
def test_a_configuration_lies_on_a_self_motion_of_its_pose(name, rng):
    robot = arm(name)
    for q in robot.random(rng, 3):
        found = robot.all_solutions(robot.pose(q))
        assert found.status is rik.SolutionsStatus.CURVES
        assert len(found) == len(found.self_motions)
        assert holds(robot, found, q)


@pytest.mark.parametrize("name", ARMS)
def test_the_tool_stands_still_along_each_within_limits(name, rng):
    robot = arm(name)
    T = robot.pose(robot.random(rng))
    for curve in robot.all_solutions(T).self_motions:
        values = robot.joint_values(curve.q)
        steps = np.linalg.norm(apart_each(robot, curve.q[1:], curve.q[:-1]), axis=-1)
        assert max(misses(robot, q, T) for q in curve.q[::7]) < 1e-9
        inside = (values >= robot.lower - 1e-8) & (values <= robot.upper + 1e-8)
        assert (inside | np.isinf(robot.upper)).all()
        assert len(steps) == 0 or steps.max() < 0.25
        if curve.closed:
            assert apart(robot, curve.q[0], curve.q[-1]) < 0.25


def apart_each(robot, a, b):
    d = robot.joint_values(a) - robot.joint_values(b)
    return np.where(robot.sliding, d, d - 2 * np.pi * np.round(d / (2 * np.pi)))


def test_an_open_curve_ends_where_a_joint_is_at_its_limit(rng):
    robot = arm("panda")
    ends = [
        q for T in robot.pose(robot.random(rng, 4)) for c in robot.all_solutions(T).self_motions for q in c.q[[0, -1]]
    ]
    room = np.minimum(np.array(ends) - robot.lower, robot.upper - np.array(ends)).min(axis=1)
    assert len(ends) > 4
    assert np.median(room) < 5e-3
    assert (room < 0.05).all()


def test_an_arm_with_spherical_shoulder_and_wrist_has_eight_circles(rng):
    """Two ways of each of shoulder, elbow and wrist; the elbow goes around the line from shoulder to wrist."""
    robot = arm("srs_7r")
    found = robot.all_solutions(robot.pose(robot.random(rng)))
    assert len(found.self_motions) == 8
    assert all(curve.closed for curve in found.self_motions)
    for curve in found.self_motions:
        assert_allclose(np.ptp(curve.q[:, 3]), 0, atol=1e-9)  # the elbow does not bend
        assert robot.joint_names[3] not in curve.moving
        assert (curve.sigma > 0).all()


def test_a_planar_arm_with_three_joints_keeps_its_tip_on_one_or_two_curves(rng):
    """Source: the four-bar linkage has one or two assembly circuits (Grashof)."""
    robot = rik.load("planar_3r")
    counts = {len(robot.all_solutions(robot.pose(q)).self_motions) for q in robot.random(rng, 12)}
    assert counts <= {1, 2}


def test_curves_are_counted_once_whatever_is_held(rng):
    robot = arm("pa10")
    for q in robot.random(rng, 2):
        curves = robot.all_solutions(robot.pose(q)).self_motions
        for i, one in enumerate(curves):
            for other in curves[:i]:
                middle = one.q[len(one.q) // 2]
                assert apart(robot, other.q, middle).min() > 1e-3


def test_a_self_motion_of_a_singular_pose_is_cut_at_limits():
    """A straight wrist turns joints 4 and 6 against each other, as far as both may."""
    robot = dh_arms.arm("kr16_like", (-1.0, 1.0))
    found = robot.all_solutions(robot.pose(np.array([0.2, -0.3, 0.4, 0.5, 0.0, 0.1])))
    (curve,) = found.self_motions
    assert not curve.closed
    assert (np.abs(curve.q) <= 1.0 + 1e-9).all()
    assert_allclose(sorted([curve.q[0, 3], curve.q[-1, 3]]), [-0.4, 1.0], atol=2e-3)
    assert ((found.q >= robot.lower) & (found.q <= robot.upper)).all()
