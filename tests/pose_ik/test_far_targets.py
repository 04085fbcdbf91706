"""Targets far away, of robots that begin with slides without limits: all are reached, as those nearby are."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.pose_ik.free_slides import FreeSlides
from robust_ik.robot.robot import Robot

COUNT = 100
"""Targets at each distance."""


def poses_of(robot, far, rng):
    """Poses that the robot reaches with its base moved so far in a random direction, and positions of that base."""
    values = robot.joint_values(robot.random(rng, COUNT))
    angle = rng.uniform(0, 2 * np.pi, COUNT)
    values[:, :2] = far * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return robot.pose(robot.configuration(values))


@pytest.mark.parametrize("far", [0.0, 50.0, 1e5])
@pytest.mark.parametrize("base", ["planar", "floating"])
@pytest.mark.parametrize("name", ["ur5", "panda", "puma560", "almarkhi_4dof"])
def test_a_pose_is_reached_by_default_however_far_the_base_must_go(name, base, far, rng):
    robot = rik.load(name, base=base)
    targets = poses_of(robot, far, rng)
    found = robot.solve_poses(targets)
    assert found.solved.all()
    part = slice(None) if len(robot.rows) == 6 else np.s_[..., :3, 3]
    assert_allclose(robot.pose(found.q)[part], targets[part], rtol=0, atol=1e-7)
    values = robot.joint_values(found.q)
    assert (values >= robot.lower).all()
    assert (values <= robot.upper).all()


def test_a_far_target_takes_no_more_work_than_a_near_one(rng):
    robot = rik.load("ur5", base="planar")
    near, far = (robot.solve_poses(poses_of(robot, distance, rng)).iterations.mean() for distance in (0.0, 1000.0))
    assert far < 3 * near


def test_one_far_target_gives_the_bits_that_many_give_and_so_from_any_layout(rng):
    robot = rik.load("ur5", base="planar")
    targets = poses_of(robot, 77.5, rng)
    q0 = robot.random(rng, COUNT)
    many = robot.solve_poses(targets, q0)
    for i in range(0, COUNT, 9):
        assert (robot.solve_pose(targets[i], q0[i]).q == many.q[i]).all()
        assert (robot.solve_pose(targets[i].tolist(), q0[i].tolist()).q == many.q[i]).all()
        assert (robot.solve_pose(np.asfortranarray(targets[i]), q0[i]).q == many.q[i]).all()


def test_a_far_target_that_is_moved_along_the_slides_moves_the_solution(rng):
    robot = rik.load("ur5", base="planar")
    for target in poses_of(robot, 3.0, rng)[:20]:
        moved = target.copy()
        moved[:2, 3] += [512.0, -256.0]  # exact in doubles
        one = robot.solve_pose(target, robot.rest, solutions=3)
        values = robot.joint_values(robot.rest)
        other = robot.solve_pose(
            moved, robot.configuration(values + np.pad([512.0, -256.0], (0, robot.n - 2))), solutions=3
        )
        assert_allclose(robot.joint_values(other.solutions)[:, 2:], robot.joint_values(one.solutions)[:, 2:], atol=1e-6)
        apart = other.solutions[:, :2] - one.solutions[:, :2]
        assert_allclose(apart, np.broadcast_to([512.0, -256.0], apart.shape), atol=1e-6)


def test_the_solution_that_is_near_the_start_is_preferred_far_away_too(rng):
    robot = rik.load("ur5", base="planar")
    values = robot.joint_values(robot.random(rng, 20))
    values[:, :2] += [300.0, 400.0]
    for each in values:
        q = robot.configuration(each)
        assert_allclose(robot.solve_pose(robot.pose(q), q).q, q, atol=1e-9)


def test_positions_and_chosen_rows_are_reached_far_away():
    robot = rik.load("ur5", base="planar")
    found = robot.solve_pose([300.0, -400.0, 0.6])
    assert found.solved
    assert_allclose(robot.pose(found.q)[:3, 3], [300.0, -400.0, 0.6], atol=1e-8)
    target = robot.pose(found.q)
    assert robot.solve_pose(target, rows=("x", "y", "wz")).solved


@pytest.mark.parametrize("given", [list, np.array])
@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e300, "far"])
def test_targets_and_starts_that_cannot_be_are_refused_as_for_any_robot(bad, given):
    robot = rik.load("ur5", base="planar")
    target, q0 = robot.pose(robot.rest).tolist(), robot.rest.tolist()
    target[0][3] = q0[0] = bad
    with pytest.raises(rik.InputError, match="target"):
        robot.solve_pose(given(target))
    with pytest.raises(rik.InputError, match="q0"):
        robot.solve_pose(robot.pose(robot.rest), given(q0))


def test_a_target_and_a_start_of_whole_numbers_are_taken():
    robot = rik.load("ur5", base="planar")
    target = np.eye(4, dtype=int)
    target[0, 3] = 70
    found = robot.solve_pose(target, np.round(robot.neutral).astype(int))
    assert found.solved
    assert_allclose(robot.pose(found.q), target, atol=1e-7)


def slides_of(robot: Robot):
    return FreeSlides.of(robot.chain(), robot.lower, robot.upper, robot.length_scale)


def test_only_slides_in_front_that_have_no_limits_and_are_not_followed_go_far():
    assert slides_of(rik.load("ur5")) is None
    assert slides_of(rik.load("ur5", base="planar")).places.tolist() == [0, 1]
    assert slides_of(rik.load("ur5", base="floating")).places.tolist() == [0, 1, 2]
    assert slides_of(rik.load("tiago")) is None  # its first joint is a lift with limits
