"""Motions to a target that stands still come to rest, whatever limits act on the way."""

from dataclasses import replace

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.control.bounds import Bounds
from robust_ik.control.limits import CollisionLimit, JointLimits
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.within_bounds.level_fit import Wish
from robust_ik.control.within_bounds.limiters import RISE
from robust_ik.control.within_bounds.motion_cost import PRICE, motion_cost
from robust_ik.control.within_bounds.null_space import Freedom
from robust_ik.control.within_bounds.overshoot_limit import steadied
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.control.control_layout import RISING, SOFT
from tests import closed_loop
from tests.cases_resolvers import LIMITERS, named_box, random_matrix
from tests.conftest import moved_start

CALM = [each for each in LIMITERS if each != rik.Scaling()]


def last_seconds(robot, controller, q, stack, dt, seconds):
    """Where the arm ends, and what it was asked for in the last second."""
    q, asked = moved_start(robot, q), []
    for _ in range(int(seconds / dt)):
        asked.append(controller.step(q, stack, dt).qdot)
        q = robot.integrate(q, dt * asked[-1])
    return q, np.array(asked[-int(1 / dt) :])


@pytest.mark.parametrize("limiter", CALM, ids=repr)
def test_no_joint_moves_but_for_progress(limiter, rng):
    """ẋᵀ P J q̇ ≥ q̇ᵀ H q̇ wherever rest is inside the limits; half of it where the direction is kept, and a quarter
    where one comes after the other."""
    part = 0.25 if limiter == rik.Sliding() else 0.5 if limiter.stops else 1.0
    for _ in range(300):
        n, m = int(rng.integers(2, 8)), int(rng.integers(1, 7))
        J, xdot = random_matrix(rng, m, n, rng.choice([None, 0.0, 1e-6, 1e-2])), rng.normal(size=m)
        reach = float(rng.choice([0.0, 0.01, 0.1]))
        reduced = Freedom.whole(n).reduce(J)
        motion = rik.JParse().solve(J, xdot)
        room = np.where(rng.random((2, n)) < 0.3, 0.0, rng.uniform(0, 0.5, (2, n)))
        wish = Wish(np.zeros(n), motion, reduced, Freedom.whole(n), named_box(-room[0], room[1]), reach)
        qdot, _ = limiter.limit(wish)
        cost = motion_cost(reduced, reach)
        H = (cost.directions * cost.weights) @ cost.directions.T
        assert motion @ H @ qdot >= part * (qdot @ H @ qdot) - 1e-9


def test_the_price_has_its_floor_everywhere_and_rises_with_how_far_a_step_wants_to_go(rng):
    for small in (None, 1e-3, 0.0):
        reduced = Freedom.whole(6).reduce(random_matrix(rng, 4, 6, small))
        least = [motion_cost(reduced, reach).weights.min() for reach in (0.0, 0.01, 1.0, 1e9, 1e300)]
        np.testing.assert_allclose(least[:2], [PRICE, PRICE + 0.01 / reduced.sigma_max])
        assert least[-2:] == [1.0, 1.0]
        basis = motion_cost(reduced).directions
        np.testing.assert_allclose(basis.T @ basis, np.eye(6), atol=1e-12)


@pytest.mark.parametrize("name", ["planar_3r", "panda", "ur5", "ur10", "xarm7", "kinova_gen3", "z1", "so101", "pa10"])
def test_the_floor_is_above_the_curvature_that_a_step_passes(name, rng):
    """|ẋ · ∂J| along a unit motion twice is below 2 ‖ẋ‖ σ₁, half of which times Δt the floor has."""
    robot = rik.load(name)
    for q in robot.random(rng, 60):
        J, H, xdot = robot.jacobian(q), robot.hessian(q), rng.normal(size=len(robot.rows))
        bent = np.einsum("i,ijk->jk", xdot / np.linalg.norm(xdot), H)
        most = np.abs(np.linalg.eigvalsh((bent + bent.T) / 2)).max() / np.linalg.norm(J, 2)
        assert most < 2
        assert most < 1 or name == "planar_3r"  # what steady motion counts on; not so of positions of a folded arm


SMALL = 1e-6
STEEPEST = {True: 5e4, False: 300.0}
"""|Δq̇| over |Δq| + |Δx|, 1/s: of limiters that keep the direction as long as they can, and of the others."""


RESOLVERS = [rik.TaskPriority(limiter=each) for each in CALM] + [rik.WeightedPriority()]


@pytest.mark.parametrize("resolver", RESOLVERS, ids=repr)
@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_velocities_are_lipschitz_in_arm_and_target_where_joints_are_at_their_limits_or_near(resolver, name):
    robot, rng, acting = rik.load(name), np.random.default_rng(7), set()
    lower, upper = np.maximum(robot.lower, -2.8), np.minimum(robot.upper, 2.8)
    limits = rik.JointLimits.of(robot, lower=lower, upper=upper)
    limiter = getattr(resolver, "limiter", None)
    keeps = limiter == rik.Sliding() or (limiter is not None and limiter.stops)
    for _ in range(80):
        q, target = rng.uniform(lower, upper), robot.pose(rng.uniform(lower, upper))
        near, some = rng.choice([0.0, 1e-4, 1e-2], robot.n), rng.random((2, robot.n)) < 0.5
        q = np.where(some[0], np.where(some[1], lower + near, upper - near), q)
        aside = rng.normal(size=robot.n)
        moved = np.clip(q + SMALL * aside / np.linalg.norm(aside), lower, upper)
        shifted = target.copy()
        shifted[:3, 3] += SMALL * rng.normal(size=3)

        def velocity(at, there):
            task = rik.FrameTask(there, gain=5.0, max_linear=0.04, max_angular=0.2)
            step = rik.VelocityController(robot, resolver, limits).step(at, task, 0.01)
            acting.add(step.active)
            return step.qdot

        here = velocity(q, target)
        for at, there in ((moved, target), (q, shifted)):
            change = np.linalg.norm(at - q) + np.linalg.norm(there - target)
            assert np.linalg.norm(velocity(at, there) - here) <= STEEPEST[keeps] * change + 1e-9
    assert len(acting) > 15


@pytest.mark.parametrize("limiter", CALM, ids=repr)
def test_a_joint_at_its_end_that_begins_to_be_asked_to_go_on_stops_the_others_in_no_jump(limiter):
    resolver, asked = rik.TaskPriority(limiter=limiter), np.linspace(-0.01, 0.1, 3001)
    box = named_box([-9.0, -9.0], [0.0, 9.0])
    given = [
        resolver.resolve(VelocityProblem((TaskEquation(np.eye(2), np.array([each, 1.0]), np.zeros(2)),), box)).qdot[1]
        for each in asked
    ]
    assert np.abs(np.diff(given)).max() < 0.1
    assert min(given) < 0.1 or not limiter.stops


def test_a_limiter_is_told_how_far_its_level_wants_to_go_in_a_step():
    strides = []

    class Told(rik.Limiter):
        def limit(self, wish):
            strides.append(wish.stride)
            return wish.motion, 1.0

    equations = (TaskEquation(np.eye(3)[:1], np.array([3.0]), np.zeros(1)),
                 TaskEquation(np.array([[1.0, 1.0, 0.0]]), np.array([5.0]), np.zeros(1)))  # fmt: skip
    rik.TaskPriority(rik.MoorePenrose(), Told()).resolve(VelocityProblem(equations, Bounds.free(3), 0.01))
    np.testing.assert_allclose(strides, [0.03, 0.02])  # 3 of the second level's 5 is done by the first
    strides.clear()
    robot = rik.load("planar_3r")
    rik.VelocityController(robot, rik.TaskPriority(limiter=Told())).step(robot.rest, rik.TwistTask(np.ones(6)), 0.02)
    np.testing.assert_allclose(strides, [0.02 * np.sqrt(len(robot.rows))])


def test_a_target_behind_a_joint_limit_of_an_xarm_is_arrived_at_by_default():
    """It shook at full speed for ever: joint 4 is asked to go beyond its end."""
    robot = rik.load("xarm7")
    beyond = robot.rest.copy()
    beyond[3] = robot.upper[3] + 0.4
    target = robot.pose(beyond)
    for stack in (
        [[rik.FrameTask(target, gain=5.0)]],
        [[rik.FrameTask(target, gain=5.0)], [rik.PostureTask(robot.rest)]],
    ):
        q, asked = last_seconds(robot, rik.VelocityController(robot), robot.rest, stack, 0.005, 25.0)
        assert np.linalg.norm(robot.pose(q)[:3, 3] - target[:3, 3]) < 1e-3
        assert np.abs(asked).max() < 0.02


@pytest.mark.parametrize("limiter", LIMITERS, ids=repr)
def test_a_panda_whose_hand_goes_back_towards_its_base_comes_to_rest(limiter):
    robot = rik.load("panda")
    target = robot.pose(robot.rest).copy()
    target[:3, 3] += [-0.45, 0.0, -0.1]
    limits = [JointLimits.of(robot), CollisionLimit.of(robot)]
    controller = rik.VelocityController(robot, rik.TaskPriority(limiter=limiter), limits)
    arrives = limiter in (rik.Sliding(), rik.QuadraticProgram())
    stack = [[rik.FrameTask(target, gain=5.0)]]
    q, asked = last_seconds(robot, controller, robot.rest, stack, 0.01, 14.0 if arrives else 6.0)
    assert np.abs(asked).max() < 5e-3
    missed = np.linalg.norm(robot.pose(q)[:3, 3] - target[:3, 3])
    assert missed < (1e-3 if arrives else 0.2)


@pytest.mark.slow
def test_whole_motions_drawn_at_random_do_not_shake():
    rng = np.random.default_rng(5)
    for _ in range(12):
        draw = closed_loop.draw(rng, surroundings=("joints", "acceleration"), steps=(0.01, 0.02))
        ending = closed_loop.run(draw, steps=600)
        assert not ending.chatters, draw
        assert draw.noisy or ending.outside <= 1e-9


@pytest.mark.parametrize("resolver", [rik.WeightedPriority(rik.Chiaverini()), rik.TaskPriority(rik.JParse(0.01))])
def test_an_arm_wedged_between_itself_and_a_table_rests_and_does_not_shake_with_noise_and_lag(resolver):
    """Six distances contradict each other; a wrist that changes one by a thousandth as much as the elbow is free."""
    wedged = closed_loop.Draw("ur5", "at limits", resolver, True, 0.02, True, "collision", 676163843)
    start = [-1.249, 2.8, -2.7793, -1.6516, 2.8, 2.0972]
    exact = closed_loop.run(replace(wedged, noisy=False), seconds=20.0, start=start)
    assert exact.speed < closed_loop.REST
    noisy = closed_loop.run(wedged, seconds=2.0, start=start)
    assert not noisy.chatters
    assert noisy.speed < 0.3


def test_a_body_over_a_table_does_not_rock_from_corner_to_corner():
    """The wrist is free to turn one corner up and the other down, and only the nearer one is seen before a step."""
    resolver = rik.TaskPriority(rik.Chiaverini())
    held = closed_loop.Draw("srs_7r", "out of reach", resolver, False, 0.001, True, "collision", 697304391)
    start = [0.9085, 1.0642, 2.1065, -2.8001, 1.9012, 0.6517, 1.3434]
    noisy = closed_loop.run(held, seconds=1.0, start=start)
    assert not noisy.chatters
    assert noisy.speed < 0.1


@pytest.mark.parametrize("limiter", [each for each in LIMITERS if each.stops], ids=repr)
@pytest.mark.parametrize("speed", [0.3, 3.0])
def test_a_joint_at_its_end_with_noise_does_not_make_all_others_shake(limiter, speed, rng):
    """It is asked for a hundredth of what the others are, and its room is noise."""
    dt, noise = 0.02, 20 * closed_loop.NOISE
    wish = TaskEquation(np.eye(2), speed * np.array([0.01, 1.0]), np.zeros(2))
    run = rik.TaskPriority(rik.MoorePenrose(), limiter).begin(dt)
    given = []
    for room in noise * np.abs(rng.normal(size=300)) * (rng.random(300) < 0.5):
        given.append(run.resolve(VelocityProblem((wish,), named_box([-9, -9], [room, 9.0]))).qdot)
    assert not closed_loop.noise_shakes(np.array(given[50:]), dt)


def test_the_judge_of_shaking_tells_it_from_motion_and_from_rest():
    turns = np.where(np.arange(50) % 2, 1.0, -1.0)[:, None] * [0.0, 0.02, 1.0]
    limits = np.array([1.0, 1.0, 1.0])
    assert closed_loop.shaking(turns, limits)
    assert not closed_loop.shaking(turns * [1, 0.4, 0], limits)  # too slow to count
    assert not closed_loop.shaking(np.abs(turns), limits)  # fast, and one way
    assert closed_loop.noise_shakes(turns, 0.01)
    assert not closed_loop.noise_shakes(1e-3 * turns, 0.01)


def test_a_limiter_that_stops_a_level_lets_it_go_on_slowly_and_is_itself_where_nothing_stopped():
    J = np.eye(2)

    def at(bound):
        return VelocityProblem((TaskEquation(J, np.array([1.0, 1.0]), np.zeros(2)),), named_box([-9, -9], [bound, 9.0]))

    run = rik.TaskPriority(limiter=rik.Scaling()).begin(0.1)
    assert run.resolve(at(9.0)).scale == [1]
    assert run.resolve(at(0.0)).scale[0] < 1e-9
    shares = [run.resolve(at(9.0)).scale[0] for _ in range(20)]
    wanted = [0.0]
    while wanted[-1] < 1:
        wanted.append(min(wanted[-1] + 0.1 * min(RISE, wanted[-1] / RISING + SOFT), 1.0))
    np.testing.assert_allclose(shares[: len(wanted) - 1], wanted[1:], atol=1e-9)  # of a speed of 1 rad/s
    assert len(wanted) < 15
    assert shares[-1] == 1
    alone = rik.TaskPriority(limiter=rik.Scaling())
    alone.resolve(at(0.0))
    assert alone.resolve(at(9.0)).scale == [1]


@pytest.mark.parametrize("limiter", [each for each in LIMITERS if each.stops], ids=repr)
@pytest.mark.parametrize("dt", closed_loop.STEPS)
@pytest.mark.parametrize("crawl", [0.0, 1e-5])
def test_a_level_whose_own_motion_stops_it_again_and_again_rests(limiter, dt, crawl):
    """A joint is at its end in every step but one of a few, as the steps in which the level goes on bring it there."""
    run = rik.TaskPriority(rik.MoorePenrose(), limiter).begin(dt)
    wish = TaskEquation(np.eye(2), np.ones(2), np.zeros(2))
    for pause in (1, 2, 5, 30):
        rooms = [9.0 if i % (pause + 1) == pause else crawl for i in range(300)]
        given = [run.resolve(VelocityProblem((wish,), named_box([-9, -9], [room, 9.0]))).qdot for room in rooms]
        assert np.abs(given[100:]).max() < closed_loop.REST * (1 + 1e-3)  # TURN lets the other joint creep


# ---------------------------------------------------------------------------------------------- steady motion
def test_steady_motion_leaves_alone_what_does_not_overshoot(rng):
    """J-PARSE wherever γ² ≥ ½ Δt ‖ẋ‖/σ₁; the very same array."""
    for _ in range(200):
        U, V = (np.linalg.qr(rng.normal(size=(n, n)))[0] for n in (6, 7))
        s = np.sort(10.0 ** rng.uniform(-8, 0.5, 6))[::-1]
        reduced = Freedom.whole(7).reduce((U * s) @ V[:, :6].T)
        x = rng.normal(size=6) * 10.0 ** rng.uniform(-9, 9)
        gamma = rng.uniform(0.01, 0.5)
        motion, dt = rik.JParse(gamma).solve(reduced.matrix, x), 2 * gamma**2 * s[0] / np.linalg.norm(x)
        assert steadied(motion, reduced, x, 0.999 * dt) is motion
        shorter = steadied(motion, reduced, x, 100 * dt)
        along, before = reduced.motions @ shorter, reduced.motions @ motion
        most = 2 * reduced.s / reduced.s[0] * np.abs(x @ reduced.U) / np.linalg.norm(x) / (100 * dt)
        rounding = 1e-12 * np.abs(before).max()
        assert (np.abs(along) <= most * (1 + 1e-9) + rounding).all()
        np.testing.assert_allclose(along, np.clip(before, -most, most), rtol=1e-9, atol=rounding)


def test_steady_motion_of_nothing_or_with_nothing_to_do_it_is_as_it_was():
    J = np.zeros((3, 4))
    motion = np.zeros(4)
    assert steadied(motion, Freedom.whole(4).reduce(J), np.ones(3), 0.01) is motion
    J[:, :3] = np.diag([1.0, 1e-3, 0.0])
    reduced = Freedom.whole(4).reduce(J)
    assert steadied(motion, reduced, np.zeros(3), 0.01) is motion
    huge = steadied(np.full(4, 1e200), reduced, np.full(3, 1e300), 1e-3)
    assert np.isfinite(huge).all()


@pytest.mark.parametrize("name", ["xarm7", "ur5", "pa10", "z1"])
def test_by_default_a_target_out_of_reach_is_waited_for_calmly_in_long_steps_too(name):
    robot = rik.load(name)
    for dt, speed in ((0.02, 1.0), (0.005, 2.0)):
        _, shaking = beyond_reach(robot, None, dt, speed, calm=False)
        assert not shaking


def test_without_being_steady_a_stiff_inverse_shakes_there():
    robot = rik.load("xarm7")
    stiff = rik.JParse(0.01)
    assert beyond_reach(robot, stiff, 0.02, 1.0, calm=False)[1]
    assert not beyond_reach(robot, rik.TaskPriority(stiff, steady=True), 0.02, 1.0, calm=False)[1]
    assert not beyond_reach(robot, rik.WeightedPriority(stiff, steady=True), 0.02, 1.0, calm=False)[1]


def beyond_reach(robot, resolver, dt, speed, **how):
    """Joint velocities of the last half second on the way to a target far out of reach, and whether they shake."""
    rng = np.random.default_rng(2)
    q, target = moved_start(robot, robot.random(rng)), robot.pose(robot.random(rng))
    target[:3, 3] *= 1.5 * robot.size / np.linalg.norm(target[:3, 3])
    controller = rik.VelocityController(robot, resolver, **how)
    task, asked = rik.FrameTask(target, gain=5.0, max_linear=speed / 5.0, max_angular=0.8), []
    for _ in range(int(8.0 / dt)):
        asked.append(controller.step(q, task, dt).qdot)
        q = robot.integrate(q, dt * asked[-1])
    last = np.array(asked[-int(0.5 / dt) :])
    return last, closed_loop.shaking(last, robot.velocity_limit)
