"""One control step: what is checked, what is remembered, what every status says on a real robot."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.control.bounds import Bounds
from robust_ik.inverses.task_equation import TaskEquation
from tests.cases_resolvers import STRICT

PANDA = rik.load("panda")
DT = 0.01


def near(robot=PANDA, size=0.02):
    return rik.FrameTask(robot.pose(robot.integrate(robot.rest, size * np.ones(robot.n))))


# ---------------------------------------------------------------------------------------------------- statuses
def test_tracking_a_near_target_of_a_panda_says_no_more_than_that():
    step = rik.VelocityController(PANDA).step(PANDA.rest, near(), DT)
    assert step.status is rik.Status.TRACKING
    assert_allclose(step.residual, 0, atol=1e-9)
    assert step.scale == [1]
    assert step.text == f"tracking: {rik.Status.TRACKING.value}"


def test_scaled_by_a_joint_at_its_speed_limit_is_named():
    step = rik.VelocityController(PANDA).step(PANDA.rest, rik.TwistTask([0, 0, 0, 0, 0, 20.0]), DT)
    assert step.status is rik.Status.SCALED
    assert 0 < step.scale[0] < 1
    assert any(f"{name} velocity" in step.active for name in PANDA.joint_names)
    assert step.active[0] in step.text
    assert f"level 1 gets {step.scale[0]:.0%}" in step.text
    assert "less speed" in step.text


def test_scaled_by_the_inverse_near_a_singularity_and_without_limits_says_so():
    robot = rik.load("ur5")
    q = np.array([0.0, -1.0, 0.02, 0.5, 1.0, 0.0])  # the elbow nearly straight
    step = rik.VelocityController(robot, limits=()).step(q, rik.TwistTask([0.1, 0.1, 0.1, 0, 0, 0]), DT)
    assert step.status is rik.Status.SCALED
    assert step.scale == [1]
    assert "near a singularity" in step.text


def test_stuck_where_the_target_pulls_along_a_straight_arm():
    robot = rik.load("planar_2r")
    step = rik.VelocityController(robot).step([0.0, 0.0], rik.TwistTask([1.0, 0, 0, 0, 0, 0]), DT)
    assert step.status is rik.Status.STUCK
    assert "Level 1 is singular, corank 1" in step.text
    assert "lead the target elsewhere" in step.text


def test_stuck_at_a_joint_limit_names_the_joint():
    robot = rik.load("planar_2r")
    limits = rik.JointLimits.of(robot, lower=[-1, 0.5], upper=[1, 2])
    controller = rik.VelocityController(robot, rik.JParse(), limits)
    step = controller.step([1.0, 1.0], rik.JointTask("joint1", 2.0), DT)
    assert step.status is rik.Status.STUCK
    assert "joint1 position" in step.active
    assert "joint1 position" in step.text


def test_infeasible_where_a_joint_is_too_fast_to_stop_names_what_yields():
    limits = rik.JointLimits.of(PANDA, acceleration=1.0)
    controller = rik.VelocityController(PANDA, limits=limits)
    controller.reset([2.0, 0, 0, 0, 0, 0, 0])
    q = PANDA.rest.copy()
    q[0] = PANDA.upper[0] - 0.05
    step = controller.step(q, near(), DT)
    assert step.status is rik.Status.INFEASIBLE
    assert step.contradictions == ("panda_joint1 acceleration",)
    assert "panda_joint1 acceleration" in step.text
    assert "Slow down earlier" in step.text
    assert q[0] + DT * step.qdot[0] <= PANDA.upper[0]


def test_an_algorithmic_singularity_is_told_from_a_kinematic_one():
    """Planar 3R: position before orientation; J₂N₁ = 0 where links 1 and 2 are in line: det J = l₁ l₂ sin q₂."""
    robot = rik.load("planar_3r")
    position, orientation = rik.TwistTask([0.1, 0, 0.1, 0, 0, 0]), rik.TwistTask([0, 0, 0, 0, 1, 0], rows=("wy",))
    for q2, expected in ((0.0, True), (1e-9, True), (1e-3, True), (1.2, False)):
        step = rik.VelocityController(robot).step([0.3, q2, 1.5], [[position], [orientation]], DT)
        first, second = step.levels
        assert not first.algorithmic
        assert first.corank == second.kinematic_corank == 0
        assert second.algorithmic == expected
        assert ("Level 2 is near an algorithmic singularity" in step.text) == expected
        assert_allclose(first.residual, 0, atol=1e-9)
        assert np.abs(step.qdot).max() < 60
    kinematic = rik.VelocityController(robot).step([0.3, 0.0, 0.0], [[position], [orientation]], DT)
    assert kinematic.levels[0].kinematic_corank == 1
    assert not kinematic.levels[0].algorithmic


# ------------------------------------------------------------------------------------------------------ limits
def test_the_default_limits_are_the_robots_own_and_none_are_none():
    fast = rik.TwistTask([0, 0, 0, 0, 0, 50.0])
    own = rik.VelocityController(PANDA).step(PANDA.rest, fast, DT)
    free = rik.VelocityController(PANDA, limits=()).step(PANDA.rest, fast, DT)
    assert (np.abs(own.qdot) <= PANDA.velocity_limit).all()
    assert (np.abs(free.qdot) > PANDA.velocity_limit).any()
    assert rik.VelocityController(PANDA).limits[0].joint_names == PANDA.joint_names


def test_of_several_limits_the_first_wins_and_the_other_is_named():
    q = PANDA.rest.copy()
    q[0] = 0.5
    below, above = (
        rik.JointLimits.of(PANDA, lower=-9, upper=[0.4] + [9] * 6, velocity=9),
        rik.JointLimits.of(PANDA, lower=[0.6] + [-9] * 6, upper=9, velocity=9),
    )
    for limits, sign in (((below, above), -1), ((above, below), 1)):
        step = rik.VelocityController(PANDA, limits=limits).step(q, near(), DT)
        assert step.qdot[0] * sign > 0.05
        assert step.status is rik.Status.INFEASIBLE
        assert step.contradictions == ("panda_joint1 position",)


def test_a_single_limit_needs_no_list():
    limit = rik.JointLimits.of(PANDA)
    assert rik.VelocityController(PANDA, limits=limit).limits == (limit,)


# ------------------------------------------------------------------------------------------------------ memory
def test_accelerations_count_from_the_last_step_and_reset_forgets_it():
    limits = rik.JointLimits.of(PANDA, acceleration=1.0)
    controller = rik.VelocityController(PANDA, limits=limits)
    fast = rik.TwistTask([0, 0, 0, 0, 0, 5.0])
    speeds = [np.abs(controller.step(PANDA.rest, fast, DT).qdot).max() for _ in range(5)]
    assert_allclose(speeds, np.arange(1, 6) * DT, atol=1e-9)
    controller.reset()
    assert not controller.qdot.any()
    assert_allclose(np.abs(controller.step(PANDA.rest, fast, DT).qdot).max(), DT, atol=1e-9)
    given = np.full(7, 0.2)
    controller.reset(given)
    given[:] = 99
    assert_allclose(controller.qdot, 0.2)


def test_what_a_step_returned_cannot_change_what_the_controller_remembers():
    controller = rik.VelocityController(PANDA)
    step = controller.step(PANDA.rest, near(), DT)
    with pytest.raises(ValueError, match="read-only"):
        step.qdot[:] = 0


@pytest.mark.parametrize("resolver", [each for each in STRICT if each.inverse == rik.JParse()], ids=repr)
def test_with_acceleration_limits_lower_levels_change_nothing_above_them(resolver, rng):
    """At a singular configuration as well: what a level has lost belongs to lower levels, now and on the way."""
    limits = rik.JointLimits.of(PANDA, acceleration=5.0)
    straight = np.clip(np.zeros(7), limits.lower, limits.upper)
    for q in (PANDA.rest, straight, PANDA.random(rng)):
        idle = rik.SingularValueTask(threshold=1e-6)  # a row of zeros: the level is singular whatever q
        position = rik.PositionTask(near().target[:3, 3])
        stack = [[idle, position], [rik.PostureTask(PANDA.random(rng), gain=5.0)], [rik.DampingTask()]]
        last = 0.3 * rng.normal(size=7)
        steps = []
        for count in (1, 3):
            controller = rik.VelocityController(PANDA, resolver, limits)
            controller.reset(last)
            steps.append(controller.step(q, stack[:count], DT))
        assert_allclose(steps[1].residual, steps[0].residual, atol=1e-9)
        assert_allclose(steps[1].scale[0], steps[0].scale[0], atol=1e-6)


def test_a_short_way_to_the_aim_is_no_small_share():
    """At almost the wanted speed, acceleration limits do not slow a level by much."""
    limits = rik.JointLimits.of(PANDA, acceleration=0.1)
    controller = rik.VelocityController(PANDA, limits=limits)
    turn = rik.JointTask("panda_joint1", 1.0, max_speed=0.5)
    q = PANDA.rest.copy()
    q[0] = -1.0
    controller.reset(np.r_[0.497, np.zeros(6)])
    step = controller.step(q, turn, DT)
    assert step.scale[0] > 0.99
    assert_allclose(step.qdot[0], 0.498, atol=1e-9)


def test_an_inverse_with_a_memory_has_one_for_each_level_and_begins_anew_with_reset():
    stack = [[near()], [rik.PostureTask(PANDA.neutral)]]
    controller = rik.VelocityController(PANDA, rik.FilteredInverse(rate=5.0), limits=())
    first = [controller.step(PANDA.rest, stack, DT).qdot for _ in range(3)]
    assert not np.allclose(first[0], first[2], atol=1e-9) or np.allclose(first[0], 0)
    controller.reset()
    assert_allclose([controller.step(PANDA.rest, stack, DT).qdot for _ in range(3)], first)


# ---------------------------------------------------------------------------------------------------- arguments
@pytest.mark.parametrize("dt", [0, -0.01, np.nan, np.inf, None, "0.01"])
def test_a_time_step_that_is_none_is_refused(dt):
    with pytest.raises(rik.InputError, match="dt must be > 0, got"):
        rik.VelocityController(PANDA).step(PANDA.rest, near(), dt)


@pytest.mark.parametrize(
    "q, match",
    [
        (np.zeros((2, 7)), r"a step takes one configuration, \(nq,\), got shape \(2, 7\)"),
        (1.0, "a step takes one configuration"),
        (np.zeros(6), r"q must have shape \(\.\.\., 7\), got \(6,\); panda has joints panda_joint1"),
        (np.full(7, np.nan), "q must be finite"),
        ("home", "q must be an array of real numbers, got 'home'"),
        (["a"] * 7, "q must be an array of real numbers"),
        ([[1, 2], [3]], "q must be an array of real numbers"),
    ],
)
def test_what_is_no_configuration_is_refused(q, match):
    with pytest.raises(rik.InputError, match=match):
        rik.VelocityController(PANDA).step(q, near(), DT)


def test_a_list_of_tasks_is_one_level_and_a_task_a_stack(rng):
    q, tasks = PANDA.random(rng), [near(), rik.DampingTask()]
    alike = [rik.VelocityController(PANDA).step(q, stack, DT) for stack in (tasks, [tasks], tuple(tasks))]
    assert all((each.qdot == alike[0].qdot).all() and len(each.levels) == 1 for each in alike)
    alone = [rik.VelocityController(PANDA).step(q, stack, DT).qdot for stack in (tasks[0], tasks[:1], [tasks[:1]])]
    assert all((each == alone[0]).all() for each in alone)


@pytest.mark.parametrize(
    "stack", [None, [], "stack", [[]], [near(), []], [near(), [near()]], [[near()], []], [[1]], {}, [[near()], None]]
)
def test_what_is_no_stack_is_refused(stack):
    with pytest.raises(rik.InputError, match="stack"):
        rik.VelocityController(PANDA).step(PANDA.rest, stack, DT)


@pytest.mark.parametrize(
    "qdot, match",
    [
        (np.zeros(6), r"qdot must have shape \(\.\.\., 7\), got \(6,\)"),
        (np.zeros((2, 7)), "qdot must be the velocities of one configuration"),
        (np.full(7, np.inf), "qdot must be finite"),
        ("fast", "qdot must be an array of real numbers"),
    ],
)
def test_what_are_no_velocities_is_refused_by_reset(qdot, match):
    with pytest.raises(rik.InputError, match=match):
        rik.VelocityController(PANDA).reset(qdot)


@dataclass(frozen=True, eq=False)
class Broken(rik.Task):
    """A task of the user's own that goes wrong."""

    J: np.ndarray
    xdot: np.ndarray

    def equation(self, robot, q, *, hessian=False):
        return TaskEquation(self.J, self.xdot, np.zeros(len(self.xdot)), None, self.weight)


@pytest.mark.parametrize(
    "J, xdot, match",
    [
        (np.full((1, 7), np.nan), np.zeros(1), "J of Broken must be finite .* with NaN or infinity"),
        (np.zeros((1, 7)), np.array([np.inf]), "xdot of Broken must be finite"),
        (np.zeros((1, 6)), np.zeros(1), r"J of Broken must be finite and of shape \(1, 7\), got shape \(1, 6\)"),
        (np.zeros((2, 7)), np.zeros(1), r"J of Broken must be finite and of shape \(1, 7\), got shape \(2, 7\)"),
        (np.zeros(7), np.zeros(1), r"J of Broken must be finite and of shape \(1, 7\), got shape \(7,\)"),
    ],
)
def test_a_task_of_ones_own_that_gives_nonsense_is_named(J, xdot, match):
    for stack in ([[Broken(J, xdot)]], [[near()], [rik.DampingTask(), Broken(J, xdot)]]):
        with pytest.raises(rik.InputError, match=match):
            rik.VelocityController(PANDA).step(PANDA.rest, stack, DT)


def test_after_a_refused_step_the_controller_goes_on():
    controller = rik.VelocityController(PANDA)
    with pytest.raises(rik.InputError):
        controller.step(PANDA.rest, [], DT)
    assert controller.step(PANDA.rest, near(), DT).status is rik.Status.TRACKING


def test_joints_brake_together_though_one_must_come_back_to_its_limits():
    """One that is outside cannot slow down; it does not keep the other from braking as hard as it can."""

    controller = rik.VelocityController(rik.load("planar_2r"))
    controller._drives = {(0, 0): SimpleNamespace(share=lambda q, qdot: 0.0)}  # allows nothing
    last = np.array([0.5, -0.1])
    bounds = replace(
        Bounds.free(2),
        lower=np.array([0.45, -0.1]),
        upper=np.array([0.55, -0.1]),
        unhurried=(np.array([-3.0, -1.0]), np.array([3.0, -0.1])),
        last=last,
    )
    braking = controller._nearer_to_braking(np.zeros(2), bounds, last, np.array([0.55, -0.1]))
    assert_allclose(braking, [0.45, -0.1], atol=1e-12)
