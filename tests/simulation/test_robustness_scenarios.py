"""The scenarios of the robustness benchmark: starts have the stated corank, targets are where the name says."""

import json
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.tasks import pose_error
from robust_ik.kinematics.rotation_vectors import rotations
from robust_ik.kinematics.svd import svd
from robust_ik.simulation.robustness import KINDS, RobustnessScenario, robustness_scenarios
from robust_ik.simulation.robustness.benchmark_motions import moved, past_the_first_axis, there_and_back
from robust_ik.simulation.robustness.singular_points import length_scale, singular_point


@dataclass(frozen=True, eq=False)
class Family:
    """A row of an atlas, as far as the benchmark reads it."""

    corank: int
    samples: np.ndarray
    words: str


def families():
    """Of a UR5, as its atlas has them, with few members each."""
    rng = np.random.default_rng(3)
    wrist, elbow, both = rng.uniform(0.3, 1.5, (3, 4, 6))
    wrist[:, 4] = 0.0
    elbow[:, 2] = 0.0
    both[:, [2, 3, 4]] = 0.0, np.pi / 2, 0.0
    return [Family(1, wrist, "q5 = 0"), Family(1, elbow, "q3 = 0"), Family(2, both, "q3 = q5 = 0")]


@cache
def made(name="ur5"):
    robot = rik.load(name)
    if name == "ur5":
        return robot, robustness_scenarios(robot, families(), seed=1)
    return robot, robustness_scenarios(robot, [Family(1, np.array([[0.4, 0, 0], [0.2, 0, np.pi]]), "flat")], seed=1)


def of_kind(kind, name="ur5", **wanted):
    robot, found = made(name)
    return robot, [
        each
        for each in found
        if each.kind == kind and all(getattr(each, key) == value for key, value in wanted.items())
    ]


def sigmas(robot, values, scenario):
    return svd(robot.jacobian(robot.configuration(values)) / scenario.units[:, None]).s


def test_every_kind_is_there_and_names_are_different():
    _, found = made()
    assert {each.kind for each in found} == set(KINDS)
    assert len({each.name for each in found}) == len(found)
    assert any(each.drive for each in found)
    assert {each.dt for each in found} == {0.001, 0.01, 0.02}
    assert {each.exit for each in found if each.kind == "start"} >= {"fold", "end of reach", "turn first"}


@pytest.mark.parametrize("name", ["ur5", "planar_3r"])
def test_a_start_is_exactly_singular_or_a_rounding_beside_and_loses_what_it_says(name):
    robot, found = of_kind("start", name)
    assert found
    for each in found:
        s = sigmas(robot, each.start, each)
        assert s[-1] < 1e-10 * s[0]
        assert s[-2] > 0.05 * s[0]
        assert each.lost.shape == (len(robot.rows), 1)
        J = robot.jacobian(robot.configuration(each.start)) / each.units[:, None]
        assert np.linalg.norm(each.lost[:, 0] @ J) < 1e-9
        outward = each.exit == "end of reach"
        reached = robot.solve_pose(each.targets[-1], robot.configuration(each.start), effort="thorough").solved
        assert each.leavable == (reached and not outward)
    assert {each.leavable for each in found} == {True, False}
    exact = {each.name: each for each in found}
    beside = [each for each in found if "beside" in each.name]
    assert beside
    for each in beside:
        twin = exact[each.name.replace(", beside 1", "")]
        assert 0 < np.abs(each.start - twin.start).max() < 1e-11


def test_a_start_of_higher_corank_has_it():
    robot, found = of_kind("corank")
    assert found
    for each in found:
        s = sigmas(robot, each.start, each)
        assert s[-2] < 1e-9 * s[0]
        assert s[-3] > 0.05 * s[0]
        assert each.lost.shape == (6, 2)
        assert each.leavable


def test_a_start_whose_target_no_configuration_reaches_need_not_be_left():
    """So near to its fully folded pose that a step inwards from the stretched one leads past the hole in the middle."""
    joints = tuple(rik.DHJoint(a=a, d=0.0, alpha=0.0) for a in (0.5, 0.45))
    robot = rik.Robot.from_dh(rik.DHTable(joints, "standard", name="hollow", rows=("x", "y")))
    long = Family(1, np.array([[0.4, 0.0]]), "stretched out")
    stretched = [each for each in robustness_scenarios(robot, [long]) if each.kind == "start" and not each.drive]
    assert {each.leavable for each in stretched if each.exit == "fold"} == {True}
    thin = tuple(rik.DHJoint(a=a, d=0.0, alpha=0.0) for a in (0.5, 0.01))
    robot = rik.Robot.from_dh(rik.DHTable(thin, "standard", name="thin", rows=("x", "y")))
    found = [each for each in robustness_scenarios(robot, [long]) if each.kind == "start" and not each.drive]
    assert found
    assert not any(each.leavable for each in found)


def test_a_target_beyond_reach_cannot_be_reached_and_its_ends_can():
    robot = rik.load("planar_3r")
    stretched_out = Family(1, np.array([[0.4, 0.0, 0.0], [-1.0, 0.0, 0.0]]), "stretched out")
    found = [each for each in robustness_scenarios(robot, [stretched_out]) if each.kind == "beyond"]
    assert found
    reach = np.linalg.norm(robot.pose(robot.configuration([0.4, 0, 0]))[[0, 2], 3])
    for each in found:
        away = np.linalg.norm(each.targets[:, [0, 2], 3], axis=1)
        assert_allclose(away.max(), reach + 0.15 * each.length, atol=1e-6)
        assert_allclose(each.targets[0], robot.pose(robot.configuration(each.start)), atol=1e-12)
        assert_allclose(each.targets[-1], each.targets[0], atol=1e-12)
        assert away[0] < 0.999 * reach


def test_a_crossing_passes_the_singular_pose_at_its_distance_along_what_is_lost():
    robot, found = of_kind("cross", drive=False)
    poses = np.array([
        robot.pose(robot.configuration(values)) for each in families()[:2] for values in each.samples
    ])  # fmt: skip
    for each in found:
        distance = float(each.name.split("δ = ")[1])
        middle = (each.steps - 60) // 2  # it settles for 0.6 s behind
        apart = pose_error(poses, each.targets[middle]) / each.units
        nearest = apart[np.argmin(np.linalg.norm(apart, axis=1))]
        assert_allclose(nearest, distance * each.lost[:, 0], atol=1e-9)
        assert_allclose(each.targets[0], robot.pose(robot.configuration(each.start)), atol=1e-12)


def test_at_a_fold_the_first_lost_direction_leads_back_into_reach_and_the_kernel_moves_there():
    robot = rik.load("planar_3r")
    length = length_scale(robot, np.random.default_rng(0))
    point = singular_point(robot, np.array([0.4, 0.0, 0.0]), 1, length, "straight")
    q = robot.configuration(point.values)
    assert point.exit is rik.Exit.FOLD
    outward = robot.pose(q)[[0, 2], 3]
    assert point.lost[:, 0] @ outward < 0
    assert np.abs(robot.jacobian(q) @ point.kernel).max() < 1e-12
    bent = robot.pose(robot.integrate(q, 0.3 * point.kernel[:, 0]))[[0, 2], 3]
    assert np.linalg.norm(bent) < np.linalg.norm(outward)


def test_a_regular_configuration_and_one_that_is_nearly_singular_twice_are_no_points():
    robot = rik.load("planar_3r")
    for values in ([0.4, 1.0, 1.0], [0.4, 0.0, 1e-3]):
        assert singular_point(robot, np.array(values), 1, 0.5, "") is None
    assert singular_point(robot, np.array([0.4, 0.0, 0.0]), 2, 0.5, "") is None


def test_lines_pass_the_first_axis_at_their_offset():
    robot = rik.load("puma560")
    start = np.array([0.3, -0.8, 2.6, 0.5, 0.7, 0.9])
    first = robot.pose(robot.configuration(start))[:2, 3]
    for offset in (0.15, 0.4):
        targets = past_the_first_axis(robot, start, offset, 4.0, 0.01)
        nearest = np.linalg.norm(targets[:, :2, 3], axis=1).min()
        assert_allclose(nearest, offset * np.linalg.norm(first), rtol=0.1)
        assert_allclose(targets[-1], targets[0], atol=1e-12)


def test_the_same_seed_makes_the_same_scenarios_and_another_seed_others():
    robot, found = made()
    again, other = (robustness_scenarios(robot, families(), seed=seed) for seed in (1, 2))
    for first, second in zip(found, again):
        assert first.to_json() == second.to_json()
    assert any(not np.array_equal(first.start, second.start) for first, second in zip(found, other))


def test_a_scenario_comes_back_from_json_and_its_noise_is_the_same():
    _, found = made()
    for each in (found[0], next(one for one in found if one.kind == "line"), next(one for one in found if one.noise)):
        again = RobustnessScenario.from_json(json.loads(json.dumps(each.to_json())))
        assert again.to_json() == each.to_json()
        assert_allclose(again.disturbances()[0], each.disturbances()[0], rtol=0)
        assert bool(each.disturbances()[0].any()) == bool(each.noise)
    with pytest.raises(rik.InputError, match="this is no scenario of the benchmark"):
        RobustnessScenario.from_json({"name": "x"})
    with pytest.raises(rik.InputError, match="kind must be one of cross"):
        replace(found[0], kind="jump")


def test_feedforward_is_the_speed_of_the_targets():
    _, found = of_kind("cross", drive=False)
    each, k = found[0], 100
    wanted = pose_error(each.targets[k - 1], each.targets[k + 1]) / (2 * each.dt)
    assert_allclose(each.feedforward[k], wanted, atol=1e-12)
    assert np.abs(each.feedforward).max() > 0.1
    assert np.abs(each.feedforward[-30:]).max() < 1e-9


def test_a_robot_without_singular_configurations_of_use_is_refused():
    with pytest.raises(rik.InputError, match="no singular configuration that is alone"):
        robustness_scenarios(rik.load("planar_3r"), [Family(1, np.array([[0.3, 1.0, 1.0]]), "none")])


def test_rotations_and_straight_ways_are_what_they_say(rng):
    vectors = rng.normal(size=(20, 3))
    R = rotations(vectors)
    assert_allclose(R @ np.swapaxes(R, 1, 2), np.tile(np.eye(3), (20, 1, 1)), atol=1e-12)
    assert_allclose((R @ vectors[..., None])[..., 0], vectors, atol=1e-12)
    first = np.eye(4)
    last = moved(first, np.array([1.0, 2, 3, 0.3, 0, 0]))
    way = there_and_back(first, last, 2.0, 0.01)
    assert_allclose(way[100], last, atol=1e-12)
    assert_allclose(way[-1], first, atol=1e-12)
