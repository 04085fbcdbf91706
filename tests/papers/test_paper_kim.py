"""Kim, Marani, Chung, Yuh: the circle that leaves the reach, with one task and with two.

The sign of eq. (22) is in `test_reconstruction`, the gradient of eq. (30) in `test_derivatives`. The stand-ins are
those that the scenarios name; known numbers were computed independently with the same stand-ins.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.description.catalog import find
from robust_ik.simulation.scenarios import load_scenario

BOUND, ORIENTATION_BOUND = 0.06, 0.3
KIM = "task reconstruction"
BACK = 2.8
"""Seconds after which every method follows the circle again."""
ONE, TWO = ("kim_circle", "kim_circle_nearer"), ("kim_two_tasks", "kim_two_tasks_nearer")


@cache
def run(name, label):
    """At the paper's 1 kHz for what the paper measures; at 250 Hz for the others, to be quick."""
    dt = 0.001 if (name, label) in ((ONE[0], KIM), (ONE[0], "Chiaverini")) else 0.004
    return rik.simulate(replace(load_scenario(name), duration=BACK, dt=dt), label)


def until(run):
    """When the error is last above 1 mm, s."""
    return run.time[np.flatnonzero(run.position_error > 1e-3)[-1]]


def angle(q):
    """Of the last link from upright."""
    return np.sum(q, axis=-1) - np.pi / 2


@pytest.mark.parametrize("name, beyond", [(ONE[0], 0.09), (ONE[1], 0.04), (TWO[0], 0.09), (TWO[1], 0.04)])
def test_the_circle_has_the_papers_radius_and_leaves_its_reach(name, beyond):
    scenario = load_scenario(name)
    places = np.array([scenario.motion.path(time)[:3, 3] for time in np.linspace(0, 4, 400, endpoint=False)])
    assert_allclose(np.ptp(places[:, [0, 2]], axis=0), 0.6, atol=1e-9)
    assert_allclose(np.linalg.norm(places, axis=1).max(), 0.96 + beyond, atol=1e-9)
    assert_allclose(scenario.robot.pose(scenario.q0)[:3, 3], places[0], atol=1e-12)
    assert_allclose(places[0], [places[:, 0].min(), 0, 0], atol=1e-12)
    assert_allclose(angle(scenario.q0), 0, atol=1e-12)
    assert scenario.dt == 0.001


@pytest.mark.parametrize(
    "name, errors, ends", [(ONE[0], (0.0921, 0.0900), (2.613, 2.709)), (ONE[1], (0.0421, 0.0400), (2.412, 2.517))]
)
@pytest.mark.slow
def test_the_measure_stays_at_half_its_bound_where_chiaverinis_falls_to_nothing(name, errors, ends):
    """Figs. 3 and 4: .0300, at about half the joint speed, nearly the same error, and back on the circle sooner."""
    kim, chiaverini = run(name, "task reconstruction"), run(name, "Chiaverini")
    assert_allclose(kim.manipulability.min(), BOUND / 2, atol=1e-4)
    assert chiaverini.manipulability.min() < 1e-3
    assert 2 < chiaverini.largest_speed / kim.largest_speed < 3
    assert_allclose([each.position_error.max() for each in (kim, chiaverini)], errors, atol=1e-3)
    assert_allclose([until(each) for each in (kim, chiaverini)], ends, atol=0.01)


@pytest.mark.slow
def test_the_task_recovers_without_over_and_undershoot_where_chiaverinis_passes_its_target():
    """Figs. 3b and 4b: the error in x once its largest value is past."""
    kim, chiaverini = (
        each.error[each.error[:, 0].argmax() :, 0] for each in (run(ONE[0], KIM), run(ONE[0], "Chiaverini"))
    )
    assert kim.min() > -1e-5
    assert_allclose(chiaverini.min(), -0.0153, atol=1e-3)


def test_the_pseudo_inverse_loses_the_circle():
    """How far hangs on the last bits."""
    lost = run(ONE[0], "pseudo-inverse")
    assert lost.largest_speed > 20 * run(ONE[0], "Chiaverini").largest_speed
    assert lost.position_error.max() > 2 * run(ONE[0], "Chiaverini").position_error.max()


@pytest.mark.parametrize("dt, least", [(0.005, 0.0300), (0.01, 0.0300), (0.02, 0.0280)])
def test_the_bound_holds_up_to_the_length_of_a_step(dt, least):
    found = rik.simulate(replace(load_scenario(ONE[0]), duration=BACK, dt=dt), "task reconstruction")
    assert_allclose(found.manipulability.min(), least, atol=2e-4)


@pytest.mark.parametrize("lengths", [(0.35, 0.35, 0.26), (0.32, 0.32, 0.32)])
def test_other_link_lengths_of_the_same_sum_give_the_same_picture(lengths):
    scenario = load_scenario(ONE[0])
    table = rik.read_dh(find("planar_3r").path)
    joints = tuple(replace(joint, a=length) for joint, length in zip(table.joints, lengths))
    robot = rik.Robot.from_dh(replace(table, joints=joints))
    q, start = scenario.q0.copy(), scenario.motion.path(0.0)
    for _ in range(20):
        q = q + np.linalg.pinv(robot.jacobian(q)) @ rik.pose_error(robot.pose(q), start)[[0, 2]]
    other = replace(scenario, robot=robot, q0=q, duration=BACK, dt=0.005)
    kim, chiaverini = (rik.simulate(other, label) for label in ("task reconstruction", "Chiaverini"))
    assert_allclose(kim.manipulability.min(), BOUND / 2, atol=3e-4)
    assert chiaverini.manipulability.min() < 2e-3
    assert chiaverini.largest_speed > 2 * kim.largest_speed
    assert_allclose([each.position_error.max() for each in (kim, chiaverini)], [0.092, 0.090], atol=2e-3)


@pytest.mark.parametrize("name", TWO)
@pytest.mark.slow
def test_two_tasks_keep_both_measures_if_drift_counts_and_lose_the_second_as_printed(name):
    """Fig. 5 and eq. (26), which leaves out what the first task does to the second measure."""
    ours, printed = run(name, "task reconstruction"), run(name, "as printed, drift left out")
    assert (ours.manipulability.min(axis=0) > [BOUND / 2 - 1e-4, ORIENTATION_BOUND / 2 - 1e-4]).all()
    assert_allclose(ours.manipulability[:, 1].min(), ORIENTATION_BOUND / 2, atol=1e-4)
    assert printed.manipulability[:, 1].min() < ORIENTATION_BOUND / 2 - 0.01
    assert 4 < ours.largest_speed < 7


def test_two_tasks_are_both_fulfilled_again_at_the_end_and_the_second_yields_where_the_circle_is_out_of_reach():
    ours = run(TWO[0], "task reconstruction")
    assert ours.position_error[-1] < 1e-4
    assert np.abs(angle(ours.q[ours.time < 0.3])).max() < 1e-3
    assert np.abs(angle(ours.q)).max() > 1


def test_without_reconstruction_two_tasks_are_thrown_and_decoupled_ones_are_not():
    assert run(TWO[0], "task priority, pseudo-inverse").largest_speed > 1e3
    assert 10 < run(TWO[0], "Chiaverini, decoupled").largest_speed < 50
