"""Pose errors and the frame task."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.tasks import FrameTask, TwistTask
from robust_ik.control.tasks.pose_difference import perpendicular, swing
from robust_ik.control.tasks.target_paths import pose
from robust_ik.kinematics.rotation_vectors import rotation_vector
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


@given(directions, directions)
def test_the_swing_leads_from_one_direction_to_another_the_shortest_way(now, wanted):
    vector = swing(now, wanted)
    angle = np.linalg.norm(vector)
    assert_allclose(rotation(vector / angle, angle) @ now if angle > 0 else now, wanted, atol=1e-10)
    assert_allclose([vector @ now, vector @ wanted], 0, atol=1e-10)
    assert_allclose(np.cos(angle), now @ wanted, atol=1e-10)


@given(directions)
def test_the_swing_to_the_opposite_is_half_a_turn_about_a_perpendicular(direction):
    vector = swing(-direction, direction)
    assert_allclose(np.linalg.norm(vector), np.pi, atol=1e-12)
    assert_allclose(vector @ direction, 0, atol=1e-7)
    assert not swing(direction, direction).any()
    frame = np.vstack([perpendicular(direction), direction])
    assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    assert_allclose(np.linalg.det(frame), 1)


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
    plain = FrameTask(target, gain=3.0).equation(robot, q)
    assert_allclose(plain.xdot, 3 * plain.error)
    assert_allclose(plain.error, rik.pose_error(robot.pose(q), target))
    assert_allclose(plain.J, robot.jacobian(q))
    capped = FrameTask(target, gain=3.0, max_linear=0.01, max_angular=0.02, feedforward=np.ones(6))
    xdot = capped.equation(robot, q).xdot - 1
    assert_allclose(np.linalg.norm(xdot[:3]), 0.03)
    assert_allclose(np.linalg.norm(xdot[3:]), 0.06)
    assert_allclose(xdot[:3] / 0.03, plain.error[:3] / np.linalg.norm(plain.error[:3]))


def test_the_cap_looks_only_at_the_rows_of_the_robot(rng):
    # A planar arm whose target lies off its plane pulls only inside the plane.
    robot = rik.load("panda").with_rows(("x", "z"))
    target = robot.pose(robot.neutral)
    target[1, 3] += 100
    equation = FrameTask(target, max_linear=0.1).equation(robot, robot.neutral)
    assert equation.J.shape == (2, 7)
    assert_allclose(equation.xdot, 0, atol=1e-12)


def test_the_target_is_copied_and_cannot_be_changed():
    target = np.eye(4)
    task = FrameTask(target)
    target[0, 3] = 5
    assert task.target[0, 3] == 0
    with pytest.raises(ValueError, match="read-only"):
        task.target[0, 3] = 5


def test_the_tip_has_the_rows_of_the_robot_and_another_frame_all_six():
    robot = rik.load("planar_3r")
    rows = robot.jacobian(robot.rest).shape[0]
    assert len(FrameTask(np.eye(4)).equation(robot, robot.rest).J) == rows < 6
    assert len(FrameTask(np.eye(4), frame=robot.tip).equation(robot, robot.rest).J) == rows
    other = next(frame for frame in robot.frames if frame != robot.tip)
    assert len(FrameTask(np.eye(4), frame=other).equation(robot, robot.rest).J) == 6
    assert len(FrameTask(np.eye(4), rows=("x", "z", "wy")).equation(robot, robot.rest).J) == 3


def test_rows_along_the_targets_axes_are_the_same_equation_turned(rng):
    robot = rik.load("panda")
    q, target = robot.random(rng), robot.pose(robot.random(rng))
    arguments = {"gain": 2.0, "max_linear": 0.1, "max_angular": 0.2, "feedforward": rng.normal(size=6)}
    world = FrameTask(target, **arguments).equation(robot, q, hessian=True)
    own = FrameTask(target, reference="target", **arguments).equation(robot, q, hessian=True)
    turn = np.kron(np.eye(2), target[:3, :3])
    for name in ("J", "xdot", "error", "hessian"):
        assert_allclose(np.tensordot(turn, getattr(own, name), 1), getattr(world, name), atol=1e-9)


@pytest.mark.parametrize("reference", ["world axes", "target"])
@pytest.mark.parametrize("free", [0, 1, 2])
@pytest.mark.parametrize("angle", [0.3, 3.0, np.pi])
def test_with_two_rotations_the_third_is_free_however_far_it_is_turned(reference, free, angle, rng):
    # Seen from the tool the free rotation comes first or last; neither leaves an error.
    robot = rik.load("panda")
    q = robot.random(rng)
    target = robot.pose(q)
    spin = rotation(np.eye(3)[free], angle)
    target[:3, :3] = target[:3, :3] @ spin if reference == "target" else spin @ target[:3, :3]
    rows = tuple(row for index, row in enumerate(("wx", "wy", "wz")) if index != free)
    equation = FrameTask(target, rows=("x", "y", "z", *rows), reference=reference).equation(robot, q)
    assert_allclose(equation.error, 0, atol=1e-12)


def test_a_five_row_task_reaches_its_target_from_a_free_angle_near_pi(rng):
    # With rows of the rotation vector instead of the swing this circles: its error turns by half the free angle.
    robot = rik.load("panda")
    q = robot.rest
    target = robot.pose(q)
    target[:3, :3] = target[:3, :3] @ rotation((0, 0, 1), 3.1) @ rotation((1, 0, 0), 0.8)
    task = FrameTask(target, rows=("x", "y", "z", "wx", "wy"), reference="target", gain=5.0)
    errors = []
    for _ in range(200):
        equation = task.equation(robot, q)
        errors.append(np.linalg.norm(equation.error[3:]))
        q = robot.integrate(q, 0.01 * np.linalg.pinv(equation.J) @ equation.xdot)
    assert_allclose(errors[0], 0.8, atol=1e-6)
    assert_allclose(errors[100], 0.8 * 0.95**100, rtol=1e-2)


def test_rows_that_the_robot_does_not_name_must_be_given():
    robot = rik.load("planar_3r")
    for task in (FrameTask(np.eye(4), reference="target"), TwistTask(np.ones(6), reference="local")):
        with pytest.raises(rik.InputError, match=r"planar_3r has the task rows x z .* give it rows"):
            task.equation(robot, robot.rest)


def test_an_unknown_frame_is_refused_with_the_names_that_exist():
    robot = rik.load("panda")
    with pytest.raises(rik.FrameNotFoundError, match="did you mean 'panda_hand'"):
        FrameTask(np.eye(4), frame="panda_hnd").equation(robot, robot.rest)


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
        ({"target": np.eye(4)[None]}, "one pose"),
        ({"target": np.eye(4), "weight": 0.0}, "weight must be > 0"),
        ({"target": np.eye(4), "rows": ("x", "x")}, "rows must be some of"),
        ({"target": np.eye(4), "rows": "xyz"}, "rows must be some of"),
        ({"target": np.eye(4), "reference": "local"}, "reference must be 'world axes' or 'target'"),
        ({"target": np.eye(4), "frame": 3}, "frame must be the name"),
    ],
)
def test_what_cannot_be_meant_is_refused(arguments, match):
    with pytest.raises(rik.InputError, match=match):
        FrameTask(**arguments)


def test_pose_from_roll_pitch_yaw_is_the_urdf_convention():
    T = pose((1, 2, 3), (0.1, 0.2, 0.3))
    assert_allclose(T[:3, :3], pin.rpy.rpyToMatrix(0.1, 0.2, 0.3), atol=1e-15)
    assert_allclose(T[:3, 3], [1, 2, 3])
