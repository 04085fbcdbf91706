"""The runs of the robustness benchmark: the drive, failures, and the numbers of runs made by hand."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.simulation.robustness import (
    BenchmarkMethod,
    ControllerMethod,
    InverseMethod,
    RobustnessScenario,
    RunScore,
    RunTrace,
    documented,
    run_scenarios,
    score,
)
from robust_ik.simulation.robustness.run_metrics import chatter

ROBOT = rik.load("planar_3r")
SPEED = np.full(3, 2.0)


def scenario(**given):
    """A target 0.1 m beside where the arm is, for a second."""
    start = np.array([0.3, 0.8, -0.9])
    target = ROBOT.pose(ROBOT.configuration(start)).copy()
    target[0, 3] += 0.1
    made = RobustnessScenario(
        name="beside", kind="start", exit="", place="", robot="planar_3r", rows=("x", "z"), start=start,
        targets=np.tile(target, (101, 1, 1)), lost=np.eye(2)[:, :1], length=0.5, dt=0.01, gain=4.0, cap=4.0,
        speed=SPEED, acceleration=10 * SPEED, leavable=True, shown=True,
    )  # fmt: skip
    return replace(made, **given)


class Told(BenchmarkMethod):
    """Gives joint velocities that it is told, whatever is asked."""

    def __init__(self, qdot):
        self.qdot, self.asked = qdot, []

    def begin(self, robot, scenarios):
        def commands(q, xdot, error):
            self.asked.append((q.copy(), xdot.copy(), error.copy()))
            if self.qdot is None:
                raise ValueError("no")
            return np.tile(self.qdot, (len(q), 1))

        return commands


def test_a_run_is_what_a_loop_of_single_steps_makes_of_it():
    each, inverse = scenario(), rik.DampedLeastSquares(0.005)
    (trace,) = run_scenarios(ROBOT, [each], InverseMethod.of(inverse))
    q = ROBOT.configuration(each.start)
    for k in range(each.steps):
        error = (each.targets[k] - ROBOT.pose(q))[[0, 2], 3]
        qdot = inverse.solve(ROBOT.jacobian(q), 4 * error)
        assert_allclose(trace.commanded[k], qdot, atol=1e-12)
        q = ROBOT.integrate(q, 0.01 * qdot)
        assert_allclose(trace.q[k + 1], q, atol=1e-12)
    found = score(ROBOT, each, trace)
    assert found.final < 0.02
    assert found.left == 1
    assert 0.3 < found.leave < 0.4  # a quarter remains after ln(4)/4 s


def test_runs_side_by_side_do_not_know_of_each_other_whatever_their_lengths_and_steps():
    several = [scenario(), scenario(dt=0.02), scenario(targets=scenario().targets[:40]), scenario(drive=True)]
    for method in (InverseMethod.of(rik.JParse()), documented(rik.Sugihara), ControllerMethod(lambda _: None)):
        together = run_scenarios(ROBOT, several, method)
        for each, trace in zip(several, together):
            (alone,) = run_scenarios(ROBOT, [each], method)
            assert_allclose(trace.q, alone.q, atol=1e-12)
            assert len(trace.commanded) == each.steps


def test_a_drive_executes_what_limits_allow_and_without_one_commands_are_executed():
    told = Told(np.array([8.0, 0.4, 0.0]))
    raw, driven = run_scenarios(ROBOT, [scenario(), scenario(drive=True)], told)
    assert_allclose(np.diff(raw.q, axis=0)[0] / 0.01, [8.0, 0.4, 0.0])
    moved = np.diff(driven.q, axis=0) / 0.01
    assert_allclose(moved[:4, 0], [0.2, 0.4, 0.6, 0.8], atol=1e-9)  # 20 rad/s²
    assert_allclose(moved[-1], [2.0, 0.1, 0.0], atol=1e-9)  # evenly slowed
    loud, quiet = score(ROBOT, scenario(), raw), score(ROBOT, scenario(drive=True), driven)
    assert (loud.speed, quiet.speed) == (4.0, 4.0)
    assert (loud.violations, quiet.violations) == (1.0, 0.0)


def test_a_command_is_no_longer_than_its_cap_and_is_measured_with_noise():
    told = Told(np.zeros(3))
    near, noisy = scenario(cap=0.2), scenario(noise=1e-3, seed=4)
    run_scenarios(ROBOT, [near], told)
    _, xdot, error = told.asked[0]
    assert_allclose(np.linalg.norm(xdot / 0.5), 0.2)
    assert_allclose(error[0], [0.1, 0.0], atol=1e-12)
    told.asked.clear()
    run_scenarios(ROBOT, [noisy], told)
    measured = np.array([q[0] for q, _, _ in told.asked])
    assert_allclose(measured - noisy.start, noisy.disturbances()[0], atol=1e-12)
    assert 0.5e-3 < np.std(measured - noisy.start) < 2e-3


@pytest.mark.parametrize("qdot", [None, np.array([np.nan, 0, 0]), np.zeros(2)])
def test_a_method_that_fails_stands_still_and_is_counted(qdot):
    (trace,) = run_scenarios(ROBOT, [scenario()], Told(qdot))
    assert trace.failed == 100
    assert_allclose(trace.q[-1], scenario().start)
    found = score(ROBOT, scenario(), trace)
    assert found.failed == 1
    assert (found.left, found.leave) == (0.0, 1.0)
    assert found.rest == 0


def by_hand(q):
    q = np.asarray(q, dtype=float)
    return RunTrace(q, np.diff(q, axis=0) / 0.01, 0, 0.0)


def test_errors_are_split_into_what_is_kept_and_what_is_lost():
    each = scenario()
    found = score(ROBOT, each, by_hand(np.tile(each.start, (101, 1))))
    assert_allclose((found.lost, found.kept, found.final), (0.2, 0.0, 0.2), atol=1e-12)  # 0.1 m of 0.5 m
    other = replace(each, lost=np.eye(2)[:, 1:])
    found = score(ROBOT, other, by_hand(np.tile(each.start, (101, 1))))
    assert_allclose((found.lost, found.kept, found.kept_peak), (0.0, 0.2, 0.2), atol=1e-12)
    none = replace(each, lost=np.zeros((2, 0)), leavable=False)
    found = score(ROBOT, none, by_hand(np.tile(each.start, (101, 1))))
    assert_allclose((found.lost, found.kept), (0.0, 0.2), atol=1e-12)
    assert np.isnan(found.leave)
    assert np.isnan(found.left)


def test_chatter_counts_changes_of_sign_of_large_accelerations():
    steady = np.linspace(0, 1, 101)[1:, None] * np.ones(2)
    assert chatter(steady, np.full(2, 20.0), 0.01) == 0
    shaking = steady.copy()
    shaking[:, 0] = 0.1 * (-1.0) ** np.arange(100)
    assert_allclose(chatter(shaking, np.full(2, 20.0), 0.01), 99 / 2)
    assert chatter(1e-3 * shaking, np.full(2, 20.0), 0.01) == 0


def test_scores_come_back_from_json():
    each = replace(scenario(), leavable=False)
    found = score(ROBOT, each, by_hand(np.tile(each.start, (101, 1))))
    again = RunScore.from_json(found.to_json())
    assert again.to_json() == found.to_json()
    assert len(again.curves) == 3
    assert np.isnan(again.leave)
    assert score(ROBOT, replace(each, shown=False), by_hand(np.tile(each.start, (101, 1)))).curves == ()


def test_the_documented_second_order_inverse_is_told_the_limits():
    inverse = documented(rik.SecondOrder).made(scenario(speed=np.array([1.5, 2.0, 3.0])))
    assert inverse.speed == 1.5
    assert documented(rik.JParse).made(scenario()) == rik.JParse()
