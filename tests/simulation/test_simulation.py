"""The control loop: bounds, stability, records. Runs of the papers: test_paper_*.py."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.compiled_loop.compiled_steps import CompiledSteps
from robust_ik.control.tasks.target_paths import pose

DT = 0.02


def test_posture_motion_never_disturbs_the_task(rng):
    robot = rik.load("panda")
    for q in robot.random(rng, 20):
        task = rik.FrameTask(robot.pose(robot.random(rng)))
        for inverse in (rik.JParse(), rik.DampedLeastSquares(0.3), rik.MoorePenrose()):
            alone = rik.VelocityController(robot, inverse, limits=()).step(q, task, DT)
            stack = [[task], [rik.PostureTask(robot.rest)]]
            both = rik.VelocityController(robot, inverse, limits=()).step(q, stack, DT)
            J = robot.jacobian(q)
            assert_allclose(J @ both.qdot, J @ alone.qdot, atol=1e-9 * (1 + np.abs(alone.qdot).max()))
            assert_allclose(both.residual, alone.residual, atol=1e-9 * (1 + np.abs(alone.qdot).max()))


@pytest.mark.parametrize("name", ["panda", "kinova", "tiago", "pa10", "puma560"])
def test_a_near_target_is_reached_and_the_record_is_consistent(name, rng):
    robot = rik.load(name)
    q0 = max(robot.random(rng, 50), key=lambda q: rik.manipulability(robot.jacobian(q)))
    target = robot.pose(robot.integrate(q0, 0.05 * rng.normal(size=robot.n)))
    run = rik.simulate(robot, rik.JParse(), rik.FrameTask(target, gain=10), q0, duration=3, dt=0.01)
    assert np.linalg.norm(run.final_error) < 1e-9
    assert run.time.shape == (300,)
    assert run.sigma.shape == (300, 6)
    assert_allclose(run.q[0], robot.integrate(q0, np.zeros(robot.n)), atol=1e-9)
    assert_allclose(robot.integrate(run.q[10], 0.01 * run.qdot[10]), run.q[11], atol=1e-12)
    assert_allclose(robot.pose(run.q[::50]), run.pose[::50])
    assert run.largest_speed == np.abs(run.qdot).max()
    assert run.seconds_per_step > 0
    with pytest.raises(ValueError, match="read-only"):
        run.q[0, 0] = 1


def test_errors_are_norms_and_the_final_one_is_against_the_last_target():
    robot = rik.load("planar_3r").with_rows(("x", "z", "wy"))
    path = rik.OutAndBack(robot.pose(robot.rest), (0.9, 0, 0.1), travel=1.0, pause=0.1, settle=0.1)
    run = rik.simulate(robot, rik.JParse(), rik.Follow(path), robot.rest, duration=0.5, dt=0.1)
    assert_allclose(run.rotation_error, np.linalg.norm(run.error[:, 3:], axis=-1))
    assert_allclose(run.position_error, np.linalg.norm(run.error[:, :3], axis=-1))
    expected = rik.pose_error(robot.pose(run.final_q), path(0.5))
    assert_allclose(run.final_error[[0, 2, 4]], expected[[0, 2, 4]], atol=1e-14)


def test_rows_that_the_task_does_not_have_report_no_error():
    robot = rik.load("planar_2r")
    run = rik.simulate(robot, rik.JParse(), rik.FrameTask(pose((1, 1, 7)), gain=10), [0.1, 1.0], duration=2)
    assert np.linalg.norm(run.final_error) < 1e-6
    assert not run.error[:, 2:].any()


def test_the_same_run_twice_is_the_same():
    short = replace(rik.load_scenario("xarm7_line"), duration=4.0)
    first, second = (rik.simulate(short, rik.JParse()) for _ in range(2))
    assert (first.q == second.q).all()


def test_progress_is_told_step_by_step():
    robot, told = rik.load("planar_2r"), []
    rik.simulate(robot, None, [[rik.FrameTask(np.eye(4))]], [0.1, 1], duration=0.05, dt=0.01,
                 progress=lambda done, total: told.append((done, total)))  # fmt: skip
    assert told == [(i, 5) for i in range(1, 6)]


def test_the_damped_loop_chatters_just_above_the_predicted_step_and_not_below():
    """G7: at an unreachable target the loop is stable for dt < 2/(φ'(0) a |v|); 2R, λ = 0.01, v = 0.02: 0.0250 s."""
    robot = rik.load("planar_2r")
    target = pose((2.2 / np.sqrt(2), 2.2 / np.sqrt(2), 0))

    def rest(dt):
        run = rik.simulate(robot, rik.DampedLeastSquares(0.01), rik.FrameTask(target, gain=0.1),
                           [np.pi / 4, 0.01], duration=2000 * dt, dt=dt, calm=False)  # fmt: skip
        return np.abs(run.q[-50:, 1]).max()

    assert rest(0.024) < 1e-7
    assert_allclose(rest(0.026), 4.5e-3, atol=5e-4)


@pytest.mark.parametrize(
    "change, match",
    [
        ({"q0": np.zeros(3)}, r"q0 must have shape \(\.\.\., 2\)"),
        ({"q0": np.zeros((2, 2))}, "one configuration"),
        ({"q0": [np.nan, 0]}, "finite"),
        ({"dt": 0.0}, "dt must be > 0"),
        ({"dt": -1.0}, "dt must be > 0"),
        ({"dt": 2.0}, "dt ≤ duration"),
        ({"duration": np.inf}, "duration must be > 0"),
        ({"duration": 1e9}, "larger dt"),
        ({"motion": rik.Follow(lambda t: np.eye(3))}, "target must have shape"),
        ({"motion": rik.Follow(lambda t: np.eye(4) if t < 0.99 else np.zeros((4, 4)))}, "must be rigid"),
        ({"motion": lambda t: np.eye(4)}, r"Follow\(path\) makes them from a path"),
        ({"motion": np.eye(4)}, r"Follow\(path\) makes them from a path"),
        ({"motion": []}, "a stack must have at least one level"),
        ({"motion": [rik.FrameTask(np.eye(4)), []]}, "a level of a stack must be a list of tasks"),
        ({"motion": [[]]}, r"at least one, such as \[task\], got \[\]"),
        ({"dt": None}, "dt must be a number, got None"),
        ({"motion": [[rik.PostureTask(np.zeros(3))]]}, r"planar_2r, \(2,\), got shape \(3,\)"),
        ({"limits": "none"}, r"limits must be limits such as JointLimits.of\(robot\), \(\) for none, got 'none'"),
    ],
)
def test_what_cannot_be_meant_is_refused(change, match):
    robot = rik.load("planar_2r")
    arguments = {"motion": rik.FrameTask(np.eye(4)), "q0": [0.1, 1.0], "duration": 1.0, "dt": 0.01} | change
    motion, q0 = arguments.pop("motion"), arguments.pop("q0")
    with pytest.raises(rik.InputError, match=match):
        rik.simulate(robot, rik.JParse(), motion, q0, **arguments)


# ----------------------------------------------------------------------------------------------------- paths
def test_keypoints_are_held_one_after_another():
    path = rik.Keypoints(np.array([pose((i, 0, 0)) for i in range(3)]), 2.0)
    assert path.duration == 6
    assert [path(t)[0, 3] for t in (-1, 0, 1.99, 2.0, 3.9, 4.0, 5, 6, 100)] == [0, 0, 0, 1, 1, 2, 2, 2, 2]


def test_out_and_back_leaves_and_returns_at_rest():
    path = rik.OutAndBack(pose((1, 0, 0)), (3, 0, 0), travel=2, pause=1, settle=1)
    x = np.array([path(t)[0, 3] for t in np.linspace(0, path.duration, 601)])
    assert (x[0], x.max(), x[-1]) == (1, 3, 1)
    assert np.abs(np.diff(x)).max() / 0.01 < 1.001 * np.pi / 2 * 2 / 2  # π/2 times the mean speed
    assert np.abs(np.diff(x, 2)).max() < 1e-3
    assert_allclose(path(2.5)[0, 3], 3)
    assert_allclose(x[-100:], 1, atol=1e-12)


@pytest.mark.parametrize("poses", [np.zeros((0, 4, 4)), np.eye(4), np.ones((2, 4, 4)), np.diag([1.0, 1, -1, 1])[None]])
def test_keypoints_are_at_least_one_rigid_pose(poses):
    with pytest.raises(rik.InputError, match="at least one pose|must be rigid"):
        rik.Keypoints(poses, 1.0)


@pytest.mark.parametrize("seconds", [0, -1, np.nan, np.inf])
def test_a_duration_that_is_no_positive_number_is_refused(seconds):
    with pytest.raises(rik.InputError, match="must be > 0"):
        rik.Keypoints(np.eye(4)[None], seconds)
    with pytest.raises(rik.InputError, match="must be > 0"):
        rik.OutAndBack(np.eye(4), (1, 0, 0), travel=seconds)


def test_a_controller_keeps_the_memory_of_its_inverse():
    robot = rik.load("panda")
    task = rik.FrameTask(robot.pose(robot.integrate(robot.rest, 0.1 * np.ones(7))))
    run = rik.VelocityController(robot, rik.FilteredInverse(rate=5.0), limits=())
    by_hand = rik.FilteredInverse(rate=5.0).begin(0.01)
    other = rik.load("panda").random(np.random.default_rng(1))
    for q in (robot.rest, other, robot.rest):
        equation = task.equation(robot, q)
        assert_allclose(run.step(q, task, 0.01).qdot, by_hand.solve(equation.J, equation.xdot))
    later = run.step(other, task, 0.01).qdot
    run.reset()
    assert not np.allclose(run.step(other, task, 0.01).qdot, later)


@pytest.mark.parametrize("robot, inverse, match", [
    ("panda", rik.JParse(), "robot must be a Robot, as rik.load gives it, got 'panda'"),
    (None, rik.JParse, r"must be a resolver such as TaskPriority\(\), or an inverse such as JParse\(\), got <class"),
    (None, "JParse", "resolver must be a resolver"),
])  # fmt: skip
def test_the_wrong_kind_of_thing_is_refused(robot, inverse, match):
    with pytest.raises(rik.InputError, match=match):
        rik.VelocityController(robot or rik.load("panda"), inverse)


def test_the_speed_ratio_is_the_worst_joints():
    robot = rik.load("panda")
    run = rik.simulate(robot, None, rik.FrameTask(robot.pose(robot.neutral)), robot.rest, duration=0.1, limits=())
    assert run.largest_speed_ratio == (np.abs(run.qdot) / robot.velocity_limit).max()
    free = rik.load("planar_2r")
    still = rik.simulate(free, None, rik.FrameTask(np.eye(4)), [0.1, 1], duration=0.1)
    assert still.largest_speed_ratio == 0


RECORDED = [
    "time", "q", "qdot", "target", "pose", "error", "sigma", "scale", "residual", "manipulability",
    "smallest_level_sigma", "corank", "algorithmic",
]  # fmt: skip


@pytest.mark.parametrize("acceleration", [np.inf, 3.0])
@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("scale", [None, 0.5])
def test_a_record_says_of_every_step_what_its_report_says(acceleration, moving, scale, monkeypatch):
    robot = rik.load("puma560")
    limits = rik.JointLimits.of(robot, velocity=0.3, acceleration=acceleration)
    far = robot.pose(robot.rest).copy()
    far[:3, 3] += [0.2, -0.6, 0.3]  # past the wrist's singularity, into limits
    stack = [[rik.FrameTask(far, gain=3.0)], [rik.PostureTask(robot.rest)]]
    motion = (lambda _: stack) if moving else stack
    given = {"duration": 3.0, "dt": 0.01, "limits": limits, "length_scale": scale}
    found = rik.simulate(robot, None, motion, robot.rest, **given)
    monkeypatch.setattr(CompiledSteps, "step", lambda *_: None)
    monkeypatch.setattr(CompiledSteps, "program", lambda *_: None)
    wanted = rik.simulate(robot, None, motion, robot.rest, **given)
    for name in RECORDED:
        assert_allclose(getattr(found, name), getattr(wanted, name), rtol=1e-6, atol=1e-7, err_msg=name)
    assert list(found.status) == list(wanted.status)
    assert found.active == wanted.active
    assert found.contradictions == wanted.contradictions
    assert any(found.active)
