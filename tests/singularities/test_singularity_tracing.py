from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.kinematics.svd import svd
from robust_ik.singularities import find_singularities, trace
from robust_ik.singularities.conditions.angle_sums import wrapped
from robust_ik.singularities.families.limit_margin import slack
from robust_ik.singularities.find.projection_search import project
from robust_ik.singularities.lost_motion.along_a_stratum import lost_along
from robust_ik.singularities.lost_motion.self_motion_way import self_motion_way
from robust_ik.singularities.trace.continuation import STEP, followed
from robust_ik.singularities.trace.family_tour import stroll

ARMS = ("almarkhi_4dof", "duleba_3r", "puma560", "slider")


@cache
def arm(name):
    if name != "slider":
        return rik.load(name)
    joints = (
        rik.DHJoint(a=0.3, d=0, alpha=1.1),
        rik.DHJoint(a=0.2, d=0, alpha=0.7, kind="prismatic", lower=-0.5, upper=0.8),
        rik.DHJoint(a=0.4, d=0.1, alpha=0.3),
    )
    return rik.Robot.from_dh(rik.DHTable(joints, "standard", rows=("x", "y", "z")))


@cache
def atlas_of(name):
    return find_singularities(arm(name), 1, starts=100)


@cache
def traced(name):
    """Atlas, the stratum with coupled joints, its curves."""
    atlas = atlas_of(name)
    (stratum,) = [row for row in atlas if row.relations or row.curve]
    return atlas, stratum, trace(atlas, stratum)


def relative_sigma(name, values, corank=1):
    """σ_{m−k+1}/σ₁ by Pinocchio."""
    robot, rows = arm(name), atlas_of(name).robot.chain.rows
    s = svd(robot.jacobian(robot.configuration(values), rows=rows)).s
    return s[..., len(rows) - corank] / s[..., 0]


# ------------------------------------------------------------------------------------------------ curves
@pytest.mark.parametrize("name", ARMS)
def test_every_point_of_a_curve_is_singular(name):
    for curve in traced(name)[2]:
        assert relative_sigma(name, curve.values).max() < 1e-9


@pytest.mark.parametrize("name", ARMS)
def test_neighbours_on_a_curve_are_near_each_other_and_free_joints_stand_still(name):
    _, stratum, curves = traced(name)
    for curve in curves:
        assert curve.ordered
        assert np.linalg.norm(curve.chords, axis=1).max() < 1.1 * STEP
        assert np.linalg.norm(curve.chords, axis=1).min() > 0
        assert np.ptp(curve.values[:, list(stratum.free)], axis=0).max(initial=0) == 0


@pytest.mark.parametrize("name", ["almarkhi_4dof", "duleba_3r", "puma560"])
def test_curves_of_angles_close_and_there_is_one_for_each_piece(name):
    _, stratum, curves = traced(name)
    assert all(curve.closed for curve in curves)
    assert len(curves) == stratum.components
    for curve in curves:
        assert_allclose(curve.values[-1] + curve.chords[-1], curve.values[0] + turns(curve), atol=1e-12)


def turns(curve):
    """Whole turns that the joints make once round."""
    return 2 * np.pi * np.round((curve.values[-1] - curve.values[0]) / (2 * np.pi))


def test_the_four_curves_of_the_4dof_arm_each_turn_its_second_joint_once():
    _, _, curves = traced("almarkhi_4dof")
    assert len(curves) == 4
    for curve in curves:
        assert curve.joints == (1, 2, 3)
        assert_allclose(np.abs(turns(curve)), [0, 2 * np.pi, 0, 0])


@pytest.mark.parametrize("name", ["almarkhi_4dof", "duleba_3r"])
def test_every_fresh_singular_point_lies_on_a_curve(name):
    atlas, stratum, curves = traced(name)
    chain = atlas.robot.chain
    found = project(chain, 1, chain.random(np.random.default_rng(99), 2500))
    values = found.values[found.converged]
    if stratum.relations:
        # Points of the other row are no members of this one.
        values = values[np.abs(stratum.relations[0].of(values)) < 1e-6]
    assert len(values) >= 500
    assert np.min([curve.distance(values) for curve in curves], axis=0).max() < 2e-3


def test_curves_do_not_repeat_each_other():
    for name in ARMS:
        curves = traced(name)[2]
        for i, curve in enumerate(curves):
            for other in curves[i + 1 :]:
                assert curve.distance(other.values).max() > 0.05


def test_a_curve_that_a_sliding_joint_ends_is_open_and_reaches_the_ends_of_its_range():
    curves = traced("slider")[2]
    assert len(curves) == traced("slider")[1].components
    for curve in curves:
        assert not curve.closed
        assert_allclose(np.sort(curve.values[[0, -1], 1]), [-0.5, 0.8], atol=1e-3)


def test_what_is_coupled_in_several_freedoms_is_shown_by_points_all_over():
    atlas, stratum, (points,) = traced("ur5")
    assert not points.ordered
    assert not points.closed
    assert points.joints == (1, 2, 3)
    assert len(points.values) > 1000
    assert relative_sigma("ur5", points.values).max() < 1e-9
    assert np.abs(stratum.relations[0].of(points.values)).max() < 1e-6
    chain = atlas.robot.chain
    fresh = project(chain, 1, chain.random(np.random.default_rng(5), 200)).values
    fresh = fresh[np.abs(stratum.relations[0].of(fresh)) < 1e-8]
    assert len(fresh) > 20
    assert np.median(points.distance(fresh)) < 0.3


def test_no_joints_coupled_no_curves():
    atlas = atlas_of("duleba_3r")
    assert all(trace(atlas, row) == () for row in atlas if not row.relations)


def test_the_same_curves_come_again():
    atlas, stratum, curves = traced("duleba_3r")
    for curve, again in zip(curves, trace(atlas, stratum), strict=True):
        assert np.array_equal(curve.values, again.values)


def test_a_way_may_be_cut_to_a_length():
    atlas, stratum, _ = traced("duleba_3r")
    (leaf,) = stratum.leaves
    way = followed(atlas.robot.chain, leaf, leaf.samples[0], None, 0.5)
    assert not way.closed
    gone = np.linalg.norm(np.diff(way.values, axis=0), axis=1).sum()
    assert 0.5 <= gone < 0.5 + STEP


# ------------------------------------------------------------------------------------------------ strolls
@pytest.mark.parametrize("name", [*ARMS, "ur5"])
def test_every_configuration_of_a_stroll_is_singular_and_it_comes_round(name):
    atlas = atlas_of(name)
    for row in atlas:
        trip = stroll(atlas.robot, row, trace(atlas, row), np.full(arm(name).n, 0.2), 61)
        assert trip.values.shape == (61, arm(name).n)
        assert relative_sigma(name, trip.values, row.corank).max() < 1e-9
        assert np.abs(np.diff(trip.values, axis=0)).max() < 0.4
        first, last = arm(name).pose(arm(name).configuration(trip.values[[0, -1]]))
        assert_allclose(first, last, atol=1e-9)
        assert np.ptp(trip.values, axis=0).max() > 0.1


def test_a_stroll_keeps_within_the_limits_where_some_of_the_family_does():
    robot = rik.load("panda")
    atlas = find_singularities(robot, 1, starts=80)
    assert len({row.within_limits for row in atlas}) == 2
    for row in atlas:
        trip = stroll(atlas.robot, row, trace(atlas, row), robot.joint_values(robot.rest), 31)
        assert trip.inside == row.within_limits, row.words
        inside = (trip.values >= robot.lower - 1e-9) & (trip.values <= robot.upper + 1e-9)
        assert inside.all() == row.within_limits


def test_joint_values_of_a_stroll_lie_between_the_limits_not_whole_turns_away():
    atlas, stratum, curves = traced("slider")
    trip = stroll(atlas.robot, stratum, curves, np.zeros(3), 61)
    assert trip.inside
    room = slack(trip.values, atlas.robot.lower, atlas.robot.upper, atlas.robot.chain.period)
    assert room.min() >= 0


# ------------------------------------------------------------------------------------------------ the way out
def test_a_stretched_arm_leaves_inwards_to_second_order():
    robot, atlas = rik.load("planar_2r"), find_singularities(rik.load("planar_2r"), 1, starts=50)
    q = np.array([0.4, 0.0])
    lost = lost_along(atlas.robot.chain, atlas.robot.tool, 1, q[None]).example
    way = self_motion_way(atlas.robot.chain, q, lost, reach=0.2, steps=20)
    assert_allclose(way.values[20], q, atol=0)
    tip = robot.pose(way.values)[:, :3, 3]
    moved = tip - tip[20]
    outwards = tip[20] / np.linalg.norm(tip[20])
    # The tool keeps to the line of what is lost, and comes nearer on both sides by κ s²/2.
    assert np.abs(np.cross(moved, outwards)).max() < 1e-4
    s = 0.2 * np.linspace(-1, 1, 41)
    assert_allclose(moved @ lost.twists[:3, 0], way.curvature * s**2 / 2, atol=2e-3 * np.abs(way.curvature))
    assert (moved @ outwards <= 1e-12).all()


def test_a_way_out_moves_the_tool_along_what_is_lost_only():
    robot, atlas = rik.load("puma560"), atlas_of("puma560")
    for row in atlas:
        q = row.samples[0]
        lost = lost_along(atlas.robot.chain, atlas.robot.tool, 1, q[None]).example
        way = self_motion_way(atlas.robot.chain, q, lost, reach=0.1, steps=50)
        J = robot.jacobian(way.values)
        kept = svd(J[50]).U[:, :5]
        steps = np.diff(way.values, axis=0)
        drift = np.einsum("ij,njk,nk->ni", kept.T, (J[1:] + J[:-1]) / 2, steps)
        assert np.abs(drift).max() < 1e-6


def test_the_distance_to_a_curve_is_that_round_the_torus():
    _, _, curves = traced("duleba_3r")
    (curve,) = curves
    assert curve.distance(curve.values + 2 * np.pi).max() < 1e-9
    middle = curve.values + curve.chords / 2
    assert curve.distance(middle).max() < 1e-9
    assert_allclose(curve.distance(curve.values[:1] + [2.0, 0, 0]), 0, atol=1e-9)  # the first joint is free
    assert np.abs(wrapped(curve.chords, curve.period) - curve.chords).max() == 0
