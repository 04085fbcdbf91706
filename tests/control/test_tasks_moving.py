"""Targets that move and commands that are sent: paths, their twists, the watchdog of teleoperation."""

import threading

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.tasks import Follow, FrameTask, PostureTask, TwistCommand
from robust_ik.control.tasks.target_paths import Keypoints, OutAndBack, pose
from tests.screws import rotation


def circling(start, radius=0.05, rate=1.3, axis=(0.6, 0.0, 0.8), spin=0.9):
    """A circle whose tool turns steadily, and the closed form of its twist."""
    axis = np.array(axis)

    def path(time):
        T = np.array(start)
        T[:3, 3] += radius * np.array([np.cos(rate * time) - 1, np.sin(rate * time), 0])
        T[:3, :3] = rotation(axis, spin * time) @ start[:3, :3]
        return T

    def twist(time):
        linear = radius * rate * np.array([-np.sin(rate * time), np.cos(rate * time), 0])
        return np.concatenate([linear, spin * axis])

    return path, twist


def test_feedforward_is_the_twist_of_the_path_also_where_it_has_turned_by_pi():
    path, twist = circling(pose((0.4, 0, 0.5), (np.pi, 0, 0)))
    follow = Follow(path, feedforward=True)
    for time in (1e-3, 0.5, np.pi / 0.9, np.pi / 0.9 + 1e-5, 2 * np.pi / 0.9, 100.0):
        task = follow(time)[0][0]
        assert_allclose(task.target, path(time))
        assert_allclose(task.feedforward, twist(time), atol=1e-7)
    # At the start there is only the way ahead.
    assert_allclose(follow(0.0)[0][0].feedforward, twist(0.0), atol=1e-4)
    assert not Follow(path)(0.5)[0][0].feedforward.any()


@pytest.mark.parametrize("feedforward", [True, False])
def test_with_feedforward_a_moving_target_is_followed_without_lag(feedforward):
    robot = rik.load("panda")
    q, dt, gain = robot.rest, 1e-3, 5.0
    path, twist = circling(robot.pose(q), spin=0.1)
    follow = Follow(path, gain=gain, feedforward=feedforward)
    for step in range(1500):
        equation = follow(step * dt)[0][0].equation(robot, q)
        q = robot.integrate(q, dt * np.linalg.pinv(equation.J) @ equation.xdot)
    lag = np.linalg.norm(rik.pose_error(robot.pose(q), path(1500 * dt))[:3])
    if feedforward:
        assert lag < 1e-4
    else:
        assert_allclose(lag, np.linalg.norm(twist(1.5)[:3]) / gain, rtol=0.1)


def test_a_jump_of_the_target_has_no_twist():
    far = Keypoints(np.stack([pose((0, 0, 0)), pose((1, 0, 0), (0, 0, 3))]), 1.0)
    follow = Follow(far, feedforward=True)
    for time in (0.0, 0.99995, 1 - 1e-8, 1.0, 1.00005, 1.9999, 2.0, 3.0):
        assert_allclose(follow(time)[0][0].feedforward, 0, atol=1e-12)
    assert follow.duration == 2.0
    assert Follow(lambda time: np.eye(4)).duration is None


def test_a_path_that_starts_and_stops_has_the_right_twist_all_along():
    path = OutAndBack(np.eye(4), (1.0, 0, 0), travel=2.0, pause=1.0, settle=1.0)
    follow = Follow(path, feedforward=True)
    for time, speed in (
        (0.0, 0),
        (1.0, np.pi / 4),
        (2.0, 0),
        (2.5, 0),
        (4.0, -np.pi / 4),
        (5.5, 0),
        (6.0, 0),
        (9.0, 0),
    ):
        assert_allclose(follow(time)[0][0].feedforward, [speed, 0, 0, 0, 0, 0], atol=2e-4)


def test_a_path_is_not_asked_before_zero_nor_after_its_end():
    class Strict:
        duration = 1.0

        def __call__(self, time):
            assert 0 <= time <= 1
            return pose((time, 0, 0))

    for time in (0.0, 5e-5, 0.5, 0.99995, 1.0):
        assert_allclose(Follow(Strict(), feedforward=True)(time)[0][0].feedforward, [1, 0, 0, 0, 0, 0], atol=1e-9)


def test_the_stack_has_the_levels_below_and_every_setting_reaches_the_task():
    posture = PostureTask(np.zeros(7))
    settings = {"gain": 2.0, "max_linear": 0.1, "max_angular": 0.2, "frame": "tool", "rows": ("x", "wx")}
    settings |= {"reference": "target", "weight": 3.0}
    stack = Follow(lambda time: np.eye(4), below=[[posture], [posture, posture]], **settings)(0.0)
    assert [len(level) for level in stack] == [1, 1, 2]
    assert stack[1][0] is posture
    assert isinstance(stack[0][0], FrameTask)
    assert {name: getattr(stack[0][0], name) for name in settings} == settings


@pytest.mark.parametrize(
    "arguments, match",
    [
        ({"path": np.eye(4)}, "path must be a function"),
        ({"gain": 0}, "gain must be > 0"),
        ({"feedforward": np.zeros(6)}, "feedforward must be True or False"),
        ({"below": [PostureTask(np.zeros(7)), []]}, "a level of below must be a list of tasks"),
        ({"below": PostureTask(np.zeros(7))}, "below must be a list of levels"),
        ({"below": [[np.zeros(7)]]}, "below must hold tasks"),
        ({"below": [[]]}, "a level of below must be a list of tasks, at least one"),
        ({"rows": ("u",)}, "rows must be some of"),
    ],
)
def test_what_cannot_be_followed_is_refused(arguments, match):
    with pytest.raises(rik.InputError, match=match):
        Follow(**{"path": lambda time: np.eye(4), **arguments})


def test_what_a_path_gives_must_be_a_pose():
    with pytest.raises(rik.InputError, match="target must be rigid"):
        Follow(lambda time: 2 * np.eye(4))(0.0)


TWIST = np.array([0.1, 0, 0, 0, 0, 0.5])


def test_the_watchdog_keeps_a_twist_then_ramps_it_down_then_stands_still_until_the_next_one():
    command = TwistCommand(timeout=0.2, ramp=0.1)
    shares = {0.0: 1, 0.2: 1, 0.225: 0.75, 0.25: 0.5, 0.3: 0, 0.31: 0, 1e6: 0}
    assert not command.twist(0.0).any()
    for start in (10.0, 10.25, 20.0):
        command.send(TWIST, start)
        for age, share in shares.items():
            assert_allclose(command.task(start + age).twist, share * TWIST, atol=1e-9)


def test_without_a_ramp_it_stops_at_once():
    command = TwistCommand(timeout=0.2, ramp=0.0)
    command.send(TWIST, 0.0)
    assert command.twist(0.2).any()
    assert not command.twist(0.2 + 1e-9).any()


def test_a_twist_from_the_future_does_not_count():
    # As where one side reads the wall clock and the other the monotonic one.
    command = TwistCommand()
    command.send(TWIST, 1.7e9)
    assert not command.twist(5e4).any()


def test_both_parts_are_capped_and_keep_their_directions():
    command = TwistCommand(max_linear=0.5, max_angular=1.0)
    command.send([3.0, 4.0, 0, 0, 0, -7.0], 0.0)
    assert_allclose(command.twist(0.0), [0.3, 0.4, 0, 0, 0, -1])
    command.send(TWIST, 0.0)
    assert_allclose(command.twist(0.0), TWIST)


def test_a_broken_twist_is_refused_and_the_last_one_runs_out():
    command = TwistCommand()
    command.send(TWIST, 0.0)
    with pytest.raises(rik.InputError, match="finite"):
        command.send([np.nan] * 6, 0.1)
    assert_allclose(command.twist(0.1), TWIST)
    assert not command.twist(0.35).any()
    for now in (np.nan, np.inf, "soon"):
        with pytest.raises(rik.InputError, match="now must be"):
            command.send(TWIST, now)


def test_the_clock_is_the_monotonic_one_by_default():
    command = TwistCommand(timeout=1e3, rows=("x",), frame="hand", reference="local", weight=2.0)
    command.send(TWIST)
    task = command.task()
    assert_allclose(task.twist, TWIST)
    assert (task.rows, task.frame, task.reference, task.weight) == (("x",), "hand", "local", 2.0)


def test_threads_never_see_half_a_twist():
    command, torn, stop = TwistCommand(timeout=1e3), [], threading.Event()

    def read():
        while not stop.is_set():
            twist = command.twist(0.0)
            if not (twist == twist[0]).all():
                torn.append(twist)

    reader = threading.Thread(target=read)
    reader.start()
    for value in range(500):
        command.send(np.full(6, float(value)), 0.0)
    stop.set()
    reader.join()
    assert not torn


@pytest.mark.parametrize(
    "arguments, match",
    [
        ({"timeout": 0}, "timeout must be > 0"),
        ({"ramp": -0.1}, "ramp must be ≥ 0"),
        ({"max_linear": 0}, "max_linear must be > 0"),
        ({"max_angular": np.nan}, "max_angular must be > 0"),
        ({"reference": "world"}, "reference must be"),
    ],
)
def test_a_command_that_cannot_be_meant_is_refused(arguments, match):
    with pytest.raises(rik.InputError, match=match):
        TwistCommand(**arguments)
