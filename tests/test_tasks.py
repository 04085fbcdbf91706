"""Pose errors and the frame task."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.paths import pose
from robust_ik.tasks.frame import rotation_vector
from tests.screws import rotation

unit = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array).filter(lambda v: np.linalg.norm(v) > 0.1)
directions = unit.map(lambda v: v / np.linalg.norm(v))


@given(directions, st.floats(0, np.pi - 1e-9))
def test_the_rotation_vector_undoes_rodrigues_up_to_pi(axis, angle):
    assert_allclose(rotation_vector(rotation(axis, angle)), angle * axis, atol=2e-8)


@given(directions, st.floats(0, np.pi - 1e-3))
def test_the_rotation_vector_keeps_every_digit_away_from_pi(axis, angle):
    assert_allclose(rotation_vector(rotation(axis, angle)), angle * axis, atol=1e-12)


@given(directions)
def test_at_pi_the_angle_is_pi_and_the_axis_one_of_the_two(axis):
    vector = rotation_vector(rotation(axis, np.pi))
    assert_allclose(np.linalg.norm(vector), np.pi, atol=1e-12)
    assert_allclose(abs(vector @ axis), np.pi, atol=1e-7)


@given(directions, st.floats(1e-12, 1e-6))
def test_small_angles_keep_their_relative_accuracy(axis, angle):
    assert_allclose(rotation_vector(rotation(axis, angle)), angle * axis, rtol=1e-6, atol=1e-16)


def test_the_rotation_vector_is_pinocchios_logarithm(rng):
    R = np.array([pin.SE3.Random().rotation for _ in range(50)])
    assert_allclose(rotation_vector(R), [pin.log3(one) for one in R], atol=1e-9)


def test_the_pose_error_is_the_derivative_that_the_jacobian_sees(rng):
    robot = rik.load("panda")
    q = robot.random(rng)
    dq = 1e-6 * rng.normal(size=7)
    error = rik.pose_error(robot.pose(q), robot.pose(robot.integrate(q, dq)))
    assert_allclose(error, robot.jacobian(q) @ dq, atol=1e-10)


def test_pose_errors_broadcast(rng):
    robot = rik.load("panda")
    poses = robot.pose(robot.random(rng, (4, 1)))
    targets = robot.pose(robot.random(rng, 3))
    errors = rik.pose_error(poses, targets)
    assert errors.shape == (4, 3, 6)
    assert_allclose(errors[2, 1], rik.pose_error(poses[2, 0], targets[1]))


def test_the_task_velocity_is_gain_times_the_capped_error_plus_feedforward(rng):
    robot = rik.load("panda")
    q, target = robot.random(rng), robot.pose(robot.random(rng))
    plain = rik.FrameTask(target, gain=3.0).equation(robot, q)
    assert_allclose(plain.xdot, 3 * plain.error)
    assert_allclose(plain.error, rik.pose_error(robot.pose(q), target))
    assert_allclose(plain.J, robot.jacobian(q))
    capped = rik.FrameTask(target, gain=3.0, max_linear=0.01, max_angular=0.02, feedforward=np.ones(6))
    xdot = capped.equation(robot, q).xdot - 1
    assert_allclose(np.linalg.norm(xdot[:3]), 0.03)
    assert_allclose(np.linalg.norm(xdot[3:]), 0.06)
    assert_allclose(xdot[:3] / 0.03, plain.error[:3] / np.linalg.norm(plain.error[:3]))


def test_the_cap_looks_only_at_the_rows_of_the_robot(rng):
    # A planar arm whose target lies off its plane pulls only inside the plane.
    robot = rik.load("panda").with_rows(("x", "z"))
    target = robot.pose(robot.neutral)
    target[1, 3] += 100
    equation = rik.FrameTask(target, max_linear=0.1).equation(robot, robot.neutral)
    assert equation.J.shape == (2, 7)
    assert_allclose(equation.xdot, 0, atol=1e-12)


def test_the_target_is_copied():
    target = np.eye(4)
    task = rik.FrameTask(target)
    target[0, 3] = 5
    assert task.target[0, 3] == 0


@pytest.mark.parametrize(
    "arguments, match",
    [
        ({"target": np.eye(3)}, r"target must have shape \(\.\.\., 4, 4\)"),
        ({"target": np.diag([1.0, 1, -1, 1])}, "rigid"),
        ({"target": np.diag([2.0, 1, 1, 1])}, "rigid"),
        ({"target": np.full((4, 4), np.nan)}, "finite"),
        ({"target": np.eye(4), "gain": 0.0}, "gain must be > 0"),
        ({"target": np.eye(4), "gain": np.nan}, "gain must be > 0"),
        ({"target": np.eye(4), "max_linear": -1.0}, "max_linear must be > 0"),
        ({"target": np.eye(4), "feedforward": np.zeros(3)}, "feedforward"),
    ],
)
def test_what_cannot_be_meant_is_refused(arguments, match):
    with pytest.raises(rik.InputError, match=match):
        rik.FrameTask(**arguments)


def test_pose_from_roll_pitch_yaw_is_the_urdf_convention():
    T = pose((1, 2, 3), (0.1, 0.2, 0.3))
    assert_allclose(T[:3, :3], pin.rpy.rpyToMatrix(0.1, 0.2, 0.3), atol=1e-15)
    assert_allclose(T[:3, 3], [1, 2, 3])
