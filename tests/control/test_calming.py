"""An arm whose joints turn to and fro is asked for less until it is calm, whatever makes it shake."""

import copy
import itertools
import math
import pickle

import numpy as np
import pytest

import robust_ik as rik
from robust_ik.control.calming import FAST, PEAK, Calming
from robust_ik.control.scaled_levels import Units
from robust_ik.kernels.control.control_layout import AWAY, LEAST_SHARE, LESS, LESS_AGAIN, REVERSALS, SHAKES, SMALL
from tests import closed_loop
from tests.cases_resolvers import RESOLVERS
from tests.conftest import moved_start
from tests.control.test_compiled_steps import HeightTask, by_numpy

DT = 0.02
STIFF = [rik.JParse(0.01), rik.MoorePenrose(), rik.Chiaverini(1e-3, 1e-3), rik.SDLS()]


def beyond_reach(name="xarm7"):
    """An arm, its start, and a task out of its reach."""
    robot, rng = rik.load(name), np.random.default_rng(2)
    q, target = moved_start(robot, robot.random(rng)), robot.pose(robot.random(rng))
    target[:3, 3] *= 1.5 * robot.size / np.linalg.norm(target[:3, 3])
    return robot, q, rik.FrameTask(target, gain=5.0, max_linear=0.2, max_angular=0.8)


def run(controller, q, stack, dt, steps):
    """What was asked for in each step, and the shares of the tasks' speed."""
    asked, shares = [], []
    for _ in range(steps):
        step = controller.step(q, stack, dt)
        asked.append(step.qdot)
        shares.append(step.calmed)
        q = controller.robot.integrate(q, dt * step.qdot)
    return q, np.array(asked), np.array(shares)


def shaking(robot, qdot):
    """The share of half seconds in which joints shake, from 8 s on."""
    parts = [closed_loop.shaking(qdot[i : i + 25], robot.velocity_limit) for i in range(400, len(qdot), 25)]
    return np.mean(parts)


@pytest.mark.parametrize("inverse", STIFF, ids=repr)
@pytest.mark.parametrize("name", ["xarm7", "ur10"])
def test_no_inverse_goes_on_shaking_beyond_reach_in_long_steps(inverse, name):
    """Short bursts may come again as the arm creeps on; stiff ones shake nearly all the time without being calmed."""
    robot, q, task = beyond_reach(name)
    _, asked, _ = run(rik.VelocityController(robot, inverse), q, task, DT, 900)
    assert shaking(robot, asked) < 0.25
    if inverse in STIFF[:2]:
        _, asked, shares = run(rik.VelocityController(robot, inverse, calm=False), q, task, DT, 900)
        assert (shares == 1).all()
        assert shaking(robot, asked) > 0.5


def test_a_slow_swing_as_fast_as_acceleration_limits_allow_is_a_shaking_too():
    """At 3 rad/s with a period of more than a second, and twice a second would not count without these limits."""
    period, acceleration, dt = 1.2, 10.0, 0.01
    swing = acceleration * period / 4 * (2 / math.pi) * np.arcsin(np.sin(2 * np.pi * np.arange(0, 20, dt) / period))
    for limit, calms in ((acceleration, True), (1e3, False)):
        noting = Calming(np.array([0.01]), REVERSALS / np.array([limit]))
        for speed in swing:
            noting.watch(np.array([speed]), dt)
        assert (noting.share < 1) == calms


@pytest.mark.parametrize("name", ["panda", "ur5", "xarm7", "kinova_gen3"])
def test_what_a_person_waves_is_followed_in_full(name):
    """Once or twice a second, in all directions."""
    robot = rik.load(name)
    start, controller, q = robot.pose(robot.rest), rik.VelocityController(robot), moved_start(robot, robot.rest)
    for i in range(800):
        target = start.copy()
        target[:3, 3] += 0.03 * np.sin(2 * np.pi * 0.01 * i * np.array([1.0, 1.5, 2.0]))
        step = controller.step(q, rik.FrameTask(target, gain=20.0), 0.01)
        assert step.calmed == 1
        q = robot.integrate(q, 0.01 * step.qdot)


def shaken(turns, speed=0.02):
    """What is noted of a joint that turns back so many times, beside one that goes on."""
    noting = Calming(np.full(2, 0.01), np.zeros(2))
    for i in range(1 + turns):
        noting.watch(np.array([speed * (-1) ** i, 0.3]), 0.01)
    return noting


class Waving(rik.FrameTask):
    """A task of a user that moves its target by itself."""

    up = 0.0

    def equation(self, robot, q, *, hessian=False):
        there = self.target.copy()
        there[2, 3] += self.up
        return rik.FrameTask(there, gain=self.gain).equation(robot, q, hessian=hessian)


def test_what_tasks_of_ones_own_wave_is_followed_in_full():
    """Nobody can see whether they want the same as before."""
    robot = rik.load("panda")
    at = robot.pose(robot.rest)
    tasks = [HeightTask(at[2, 3], gain=30.0), Waving(at, gain=20.0)]
    made = [make(robot, None, None) for make in (rik.VelocityController, by_numpy)]
    for controller, task in itertools.product(made, tasks):
        q = moved_start(robot, robot.rest)
        controller.reset()
        for i in range(600):
            up = 0.03 * math.sin(2 * math.pi * 0.01 * i)
            if isinstance(task, HeightTask):
                object.__setattr__(task, "height", at[2, 3] + up)
            else:
                Waving.up = up
            step = controller.step(q, task, 0.01)
            assert step.calmed == 1
            q = robot.integrate(q, 0.01 * step.qdot)


def test_the_share_falls_with_each_turn_and_faster_once_it_has_fallen():
    counted = math.ceil(SHAKES)  # counts fade a little
    for turns in range(counted + 1):
        assert shaken(turns).share == 1
    for more in range(1, 6):
        assert shaken(counted + more).share == pytest.approx(LESS * LESS_AGAIN ** (more - 1))
    assert shaken(10_000).share == LEAST_SHARE


def test_the_share_stays_at_rest_and_grows_as_the_arm_gets_away_from_where_it_shook():
    noting = shaken(12)
    low = noting.share
    for i in range(1000):  # at rest, and up and down a little
        noting.watch(np.array([0.0, 0.02 * AWAY * math.cos(0.01 * i)]), 0.01)
    assert low < noting.share < 1.05 * low
    for _ in range(1000):
        noting.watch(np.array([0.0, 0.1 * AWAY]), 0.01)
    assert noting.share == pytest.approx(math.e * low, rel=0.06)
    for _ in range(1000):
        noting.watch(np.array([0.0, AWAY]), 0.01)
    assert noting.share == 1


def test_the_share_grows_once_tasks_want_something_else():
    robot, noting = rik.load("planar_2r"), Calming(np.full(2, 0.01), np.zeros(2))
    task = rik.PostureTask(np.zeros(2))
    for i in range(12):
        noting.look_at(((task,),), robot, 0.01)
        noting.watch(np.array([0.02 * (-1) ** i, 0.0]), 0.01)
    low = noting.share
    for same in (task, rik.PostureTask(np.zeros(2))):
        for _ in range(200):
            noting.look_at(((same,),), robot, 0.01)
            noting.watch(np.zeros(2), 0.01)
    assert noting.share == low < 1
    noting.look_at(((rik.PostureTask(np.ones(2)),),), robot, 0.01)
    for _ in range(200):
        noting.watch(np.zeros(2), 0.01)
    assert noting.share == 1


def test_other_targets_let_the_share_grow_in_compiled_code_too():
    robot, q, task = beyond_reach()
    loop = rik.ControlLoop(rik.VelocityController(robot, rik.JParse(0.01)), task, DT)
    for _ in range(600):
        q = robot.integrate(q, DT * loop.step(q))
    low = loop.report.calmed
    for _ in range(20):
        loop.step(q)  # of the same target
    assert loop.report.calmed <= 1.1 * low < 1  # it creeps
    loop.tasks[0][0].target[:3, 3] *= 0.5
    before, shares = loop.report.calmed, []
    for _ in range(100):
        q = robot.integrate(q, DT * loop.step(q))
        shares.append(loop.report.calmed)
    assert max(shares) > 2 * before


def test_on_the_way_to_one_target_two_turns_a_second_are_a_shaking():
    """An arm that creeps into a singularity and is kicked out of it, again and again."""
    robot, share = rik.load("planar_2r"), {}
    for moves in (False, True):
        noting = Calming(np.full(2, 0.01), np.zeros(2))
        for i in range(1000):
            target = np.full(2, 0.001 * (i // 50) if moves else 0.0)
            noting.look_at(((rik.PostureTask(target),),), robot, 0.01)
            noting.watch(np.array([-0.2 if i % 80 == 0 else 0.02, 0.0]), 0.01)
        share[moves] = noting.share
    assert share[True] == 1
    assert share[False] < 1


def test_an_arm_that_is_kicked_every_few_seconds_on_the_way_to_one_target_is_calmed():
    """The freedom of a lower level may jump where the rank of those above does."""
    robot = rik.load("planar_2r")
    for moves in (False, True):
        noting = Calming(np.full(2, 0.01), np.zeros(2))
        for i in range(3000):
            noting.look_at(((rik.PostureTask(np.full(2, 1.0 * (i // 500) if moves else 0.0)),),), robot, 0.01)
            kick = 1.3 * noting.share if i % 500 == 0 else 0.0  # a new target may turn joints back at once
            noting.watch(np.array([kick - 0.0002, 0.0]), 0.01)
        assert (noting.share < 0.4) != moves


def test_joints_that_turn_back_slowly_do_not_count():
    noting = Calming(np.full(1, 0.01), np.zeros(1))
    for i in range(1000):
        noting.watch(np.array([0.009 * (-1) ** i]), 0.01)
    assert noting.share == 1
    for i in range(1000):  # fast, but twice a second
        noting.watch(np.array([1.0 if i // 50 % 2 else -1.0]), 0.01)
    assert noting.share == 1


@pytest.mark.parametrize("period", [1.9, 5.0, 10.0, 20.0])
def test_a_swing_of_any_period_on_the_way_to_one_target_is_calmed(period):
    """However slow, it would never end; what follows a target that moves as slowly is left alone."""
    robot, dt = rik.load("planar_2r"), 0.02
    for moves in (False, True):
        noting = Calming(np.full(2, 0.01), np.zeros(2))
        for i in range(int(12 * period / dt)):
            at = math.sin(2 * math.pi * dt * i / period)
            noting.look_at(((rik.PostureTask(np.full(2, at if moves else 0.0)),),), robot, dt)
            noting.watch(np.array([0.3 * at, 0.0]), dt)
        assert (noting.share < 0.1) != moves


@pytest.mark.parametrize("steps", [1, 2, 5, 50])
def test_a_small_swing_that_neither_grows_nor_fades_is_calmed_and_what_noise_makes_is_not(steps, rng):
    robot, peak = rik.load("planar_2r"), 0.01
    noise = 0.15 * peak * rng.normal(size=6000)
    swing = [0.15 * peak * (-1) ** (i // steps) for i in range(6000)]
    fading = [peak * 0.98**i * (-1) ** i for i in range(6000)]
    for qdot, calms in ((swing, True), (noise, False), (fading, False), (np.array(swing) * SMALL, False)):
        noting = Calming(np.full(2, peak), np.zeros(2))
        for each in qdot:
            noting.look_at(((rik.PostureTask(np.zeros(2)),),), robot, 0.01)
            noting.watch(np.array([each, 0.0]), 0.01)
        assert (noting.share < 1) == calms


RESTLESS = [
    ("ur5", "at limits", rik.TaskReconstruction(rik.Chiaverini(), rik.QuadraticProgram()), False, 0.02, "acceleration",
     749886340),  # swings by 0.6 rad/s with a period of 1.9 s
    ("xarm7", "out of reach",
     rik.TaskPriority(rik.JParse(0.01), rik.QuadraticProgram(keep_direction=True), steady=True), True, 0.005,
     "acceleration", 51922809),  # turns back in every step, at 0.002 rad/s
    ("kinova_gen3", "out of reach", rik.TaskPriority(rik.Chiaverini(), rik.QuadraticProgram(keep_direction=True)), True,
     0.001, "joints", 921908255),  # starts and is stopped
    ("baxter", "out of reach", rik.DecoupledPriority(rik.JParse(), rik.QuadraticProgram(keep_direction=True)), True,
     0.005, "joints", 645446404),  # the same
    ("baxter", "out of reach",
     rik.DecoupledPriority(rik.JParse(), rik.QuadraticProgram(keep_direction=True), steady=True), True, 0.01,
     "acceleration", 219767877),  # the same
]  # fmt: skip
"""Motions that once never came to rest, found by `tests.soak`."""


@pytest.mark.parametrize(("arm", "kind", "resolver", "posture", "dt", "limits", "seed"), RESTLESS)
def test_motions_that_went_on_for_ever_come_to_rest(arm, kind, resolver, posture, dt, limits, seed):
    each = closed_loop.Draw(arm, kind, resolver, posture, dt, False, limits, seed)
    ending = closed_loop.run(each, seconds=300.0, steps=10**6)
    assert ending.speed < closed_loop.REST


def test_peaks_follow_the_limits_in_the_units_of_the_controller():
    robot = rik.load("tiago")  # its torso slides
    units = Units(0.5, robot.sliding)
    limits = rik.JointLimits.of(robot, velocity=np.r_[0.0, np.full(robot.n - 1, 0.4)], acceleration=2.0)
    told = Calming.of(robot, [limits], units, calm=True)
    speeds = np.minimum(limits.velocity, robot.velocity_limit) / units.joints
    np.testing.assert_allclose(told.peaks, PEAK * np.where(speeds > 0, np.minimum(speeds, FAST), FAST))
    np.testing.assert_allclose(told.slowness, REVERSALS * units.joints / 2.0)
    assert np.isinf(Calming.of(robot, [limits], units, calm=False).peaks).all()
    free = Calming.of(rik.load("planar_2r"), [], Units(1.0, np.zeros(2, dtype=bool)), calm=True)
    assert (free.peaks > 0).all()
    assert (free.slowness == 0).all()


@pytest.mark.parametrize("resolver", RESOLVERS, ids=repr)
def test_all_levels_ask_for_the_share_in_compiled_code_and_in_numpy(resolver, rng):
    robot = rik.load("xarm7")
    for _ in range(6):
        q, near, share = robot.random(rng), robot.pose(robot.random(rng)), float(rng.uniform(0.01, 1))
        stack = [
            [rik.PositionTask(near[:3, 3], gain=2.0)], [HeightTask(0.4), rik.OrientationTask(near[:3, :3])],
            [rik.PostureTask(robot.rest)],
        ]  # fmt: skip
        steps = []
        for controller in (rik.VelocityController(robot, resolver), by_numpy(robot, resolver, None)):
            controller.calming.memory[:2] = share
            steps.append(controller.step(q, stack, 0.01))
        found, wanted = steps
        np.testing.assert_allclose(found.qdot, wanted.qdot, atol=1e-8)
        assert found.calmed == wanted.calmed == pytest.approx(share)
        asked = stack[0][0].equation(robot, q)
        for step in steps:  # what is missing is of all that the task wants
            np.testing.assert_allclose(step.residual, asked.xdot - asked.J @ step.qdot, atol=1e-9)


@pytest.mark.parametrize("kind", [rik.TaskPriority, rik.DecoupledPriority, rik.WeightedPriority])
def test_asking_for_a_share_is_asking_with_a_smaller_gain(kind, rng):
    robot = rik.load("panda")
    resolver = kind(rik.DampedLeastSquares(0.05))
    q, target = robot.random(rng), robot.pose(robot.random(rng))
    eased = rik.VelocityController(robot, resolver)
    eased.calming.memory[:2] = 0.25
    found = eased.step(q, [[rik.FrameTask(target, gain=4.0)], [rik.PostureTask(robot.rest, gain=2.0)]], 0.01)
    slower = [[rik.FrameTask(target, gain=1.0)], [rik.PostureTask(robot.rest, gain=0.5)]]
    wanted = rik.VelocityController(robot, resolver).step(q, slower, 0.01)
    np.testing.assert_allclose(found.qdot, wanted.qdot, atol=1e-9)


@pytest.mark.parametrize("near", [False, True], ids=["joints", "collisions"])
def test_compiled_code_notes_what_numpy_notes(near):
    """Of the same velocities, step by step, in a prepared loop, and where bounds come from outside."""
    robot, q, task = beyond_reach()
    limits = [rik.JointLimits.of(robot, acceleration=30.0), *([rik.CollisionLimit.of(robot)] if near else [])]
    controller = rik.VelocityController(robot, rik.JParse(0.01), limits)
    loop = rik.ControlLoop(controller, task, DT)
    replay = Calming.of(robot, limits, Units(1.0, robot.sliding), calm=True)
    lowest = 1.0
    for _ in range(150 if near else 600):
        qdot = loop.step(q).copy()
        replay.look_at(((task,),), robot, DT)
        assert loop.report.calmed == pytest.approx(replay.share, rel=1e-12)
        replay.watch(qdot, DT)
        np.testing.assert_array_equal(controller.step(q, task, DT).qdot, qdot)
        assert controller.calming.share == pytest.approx(replay.share, rel=1e-12)
        q, lowest = robot.integrate(q, DT * qdot), min(lowest, replay.share)
    assert near or lowest < 1


def test_runs_side_by_side_and_one_by_one_are_calmed_alike():
    robot, q, task = beyond_reach()
    loop = rik.ControlLoop(rik.VelocityController(robot, rik.JParse(0.01)), task, DT)
    starts = np.array([robot.integrate(q, 1e-3 * i * np.ones(robot.n)) for i in range(9)])
    together = loop.runs(starts, 600)
    noted = [Calming.of(robot, loop.controller.limits, Units(1.0, robot.sliding), calm=True) for _ in starts]
    for run_of, each in zip(together.qdot, noted):
        for qdot in run_of:
            each.look_at(((task,),), robot, DT)
            each.watch(qdot, DT)
    assert min(each.share for each in noted) < 1
    for start, found in zip(starts, together.qdot):
        np.testing.assert_array_equal(loop.runs(start[None], 600).qdot[0], found)


def test_an_arm_that_has_been_calmed_is_soon_at_its_full_speed_again():
    robot, q, task = beyond_reach()
    controller = rik.VelocityController(robot, rik.JParse(0.01))
    q, _, shares = run(controller, q, task, DT, 600)
    assert shares[-1] < 1
    back = rik.FrameTask(robot.pose(robot.rest), gain=5.0, max_linear=0.2, max_angular=0.8)
    low = shares[-1]
    q, _, shares = run(controller, q, back, DT, 600)  # it shakes on the way, too
    assert shares[100] > 10 * low
    assert shares[-1] == 1
    assert np.linalg.norm(robot.pose(q)[:3, 3] - back.target[:3, 3]) < 1e-3


def test_a_step_says_that_it_is_calmed_and_is_not_called_tracking():
    robot = rik.load("panda")
    q, task = robot.rest, rik.TwistTask([0, 0, 0.1, 0, 0, 0])
    controller = rik.VelocityController(robot)
    assert "to and fro" not in controller.step(q, task, 0.01).text
    controller.calming.memory[:2] = 0.3
    step = controller.step(q, task, 0.01)
    assert step.status is rik.Status.SCALED
    assert "all levels ask for 0.3 of their speed" in step.text
    assert pickle.loads(pickle.dumps(step)).calmed == copy.copy(step).calmed == 0.3


def test_other_limits_keep_what_was_noted_and_a_new_run_forgets_it():
    robot, q, task = beyond_reach()
    controller = rik.VelocityController(robot, rik.JParse(0.01))
    run(controller, q, task, DT, 600)
    low = controller.calming.share
    assert low < 1
    controller.limits = rik.JointLimits.of(robot, margin=0.01)
    assert controller.calming.share == low
    assert pickle.loads(pickle.dumps(controller)).calming.share == low
    controller.reset()
    assert controller.calming.share == 1


def test_simulations_are_calm_unless_methods_are_taken_as_they_are():
    robot, q, task = beyond_reach()
    asked = {}
    for calm in (True, False):
        found = rik.simulate(robot, rik.JParse(0.01), [[task]], q, duration=18.0, dt=DT, calm=calm)
        asked[calm] = shaking(robot, found.qdot)
        assert found.calmed.shape == found.time.shape
        assert (found.calmed.min() < 1) == calm
    assert asked[True] < 0.25
    assert asked[False] > 0.5


def test_a_record_has_the_share_of_every_step_compiled_or_not(monkeypatch):
    robot, q, task = beyond_reach()
    one = rik.simulate(robot, rik.JParse(0.01), [[task]], q, duration=4.0, dt=DT)
    monkeypatch.setattr("robust_ik.simulation.run_record.RunRecord._reports", lambda _, begin: (begin + 1, None))
    other = rik.simulate(robot, rik.JParse(0.01), [[task]], q, duration=4.0, dt=DT)
    np.testing.assert_array_equal(one.calmed, other.calmed)
    assert one.calmed.min() < one.calmed[0] == 1


def test_whether_it_calms_is_yes_or_no():
    with pytest.raises(rik.InputError, match="calm must be"):
        rik.VelocityController(rik.load("panda"), calm="yes")


def test_the_way_back_from_a_singularity_is_slower_too():
    robot, resolver = rik.load("ur5"), rik.TaskReconstruction(rik.JParse(0.01), bound=0.2)
    q = moved_start(robot, np.array([0.3, -1.2, 0.4, -0.5, 0.9, 0.2]))
    stays, asked = rik.FrameTask(robot.pose(q)), {}
    for make in (rik.VelocityController, by_numpy):
        for share in (1.0, 0.1):
            controller = make(robot, resolver, ())
            controller.calming.memory[:2] = share
            asked[make, share] = controller.step(q, stays, 0.01).qdot
        assert np.linalg.norm(asked[make, 1.0]) > 1e-3
        np.testing.assert_allclose(asked[make, 0.1], 0.1 * asked[make, 1.0], atol=1e-9)
