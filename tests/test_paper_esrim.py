"""ESRIM 2020: line, arc and ten axes on stand-in arms, each past a singularity; agreement in kind only.

The lag law at the paper's own step is in `test_other_inverses`, the gains of the inverse in `test_filters`.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from robust_ik.inverses import ESRIM, TrackingLoop, Weighted
from robust_ik.scenarios import load_scenario

TOLERANCE = 0.5e-3
LAG = 0.280e-3
SCALE = np.array([1e3] * 3 + [1.0] * 3)
"""From m and rad to mm and rad."""
PAST = {"esrim_line": 22.0, "esrim_arc": 50.0, "esrim_10_axis": 40.0}
"""Seconds until each singularity is passed, of about 120 or 137."""


@cache
def run(name, label):
    return rik.simulate(replace(load_scenario(name), duration=PAST[name]), label)


def largest_step(run):
    """Largest ‖Δθ‖."""
    return np.linalg.norm(run.qdot, axis=1).max() * (run.time[1] - run.time[0])


def lyapunov(run):
    """½‖e‖² in mm and rad."""
    return 0.5 * np.sum((run.error * SCALE) ** 2, axis=1)


@pytest.mark.parametrize("name, begin, end", [
    ("esrim_line", (982.9, -399.6, -324.3), (394.5, -399.9, -441.4)),
    ("esrim_arc", (1081.5, 89.8, 753.5), (633.0, 89.8, 971.7)),  # moved by (0.9, 0.1, 0.8) mm
    ("esrim_10_axis", (1080.6, 89.7, 752.7), (632.1, 89.7, 970.9)),
])  # fmt: skip
def test_the_paths_lead_from_the_papers_start_to_its_end(name, begin, end):
    scenario = load_scenario(name)
    path = scenario.motion.path
    assert_allclose(scenario.robot.pose(scenario.q0), path(0.0), atol=1e-9)
    assert_allclose(1e3 * path(0.0)[:3, 3], begin, atol=1e-6)
    assert_allclose(1e3 * path(path.duration)[:3, 3], end, atol=0.05)
    assert scenario.motion.gain * scenario.dt == pytest.approx(5 * 0.125)
    steps = path.duration * 0.005 / 0.05e-3
    assert steps == pytest.approx(12_000 if name == "esrim_line" else 13_708, abs=2)


def test_the_printed_centre_of_the_arc_is_impossible_and_the_corrected_one_is_not():
    begin, end = np.array([1080.6, 89.7, 752.7]), np.array([632.1, 89.7, 970.9])
    printed, corrected = np.array([830.3, 457.1, 1065.2]), np.array([830.3, 89.7, 808.3])
    assert_allclose([np.linalg.norm(each - printed) for each in (begin, end)], [543.4, 428.0], atol=0.1)
    assert abs(printed[1] - begin[1]) > 300  # the normal is the y axis: begin, end and centre must have the same y
    radii = [np.linalg.norm(each - corrected) for each in (begin, end)]
    assert_allclose(radii, 256.4, atol=0.05)
    assert_allclose(corrected[2] + radii[0], 1065.2, atol=0.6)  # the printed z is that of the circle's highest point
    a, b = begin - corrected, end - corrected
    angle = np.arctan2(np.array([0, -1, 0]) @ np.cross(a, b), a @ b)
    assert_allclose([np.degrees(angle), angle * radii[0]], [153.2, 685.4], atol=0.1)


@pytest.mark.parametrize("name", PAST)
def test_esrim_passes_within_the_tolerance_with_the_smallest_steps_where_the_others_do_not(name):
    """SGIM diverges, SRIM oscillates; ESRIM's largest ‖Δθ‖ is at most a fifth of theirs."""
    sgim, srim, esrim = (run(name, label) for label in ("SGIM", "SRIM", "ESRIM"))
    assert sgim.position_error.max() > 2 * TOLERANCE
    assert srim.position_error.max() > TOLERANCE
    assert esrim.position_error.max() < 1.1 * LAG < TOLERANCE
    assert 5 * largest_step(esrim) < min(largest_step(srim), largest_step(sgim))
    assert esrim.smallest_sigma > max(srim.smallest_sigma, sgim.smallest_sigma)


def test_srim_oscillates_where_the_target_is_out_of_reach():
    """Out of reach, q4 flips from one side of the stretch to the other; with ESRIM it does not."""
    turns = {label: np.count_nonzero(np.diff(np.sign(run("esrim_arc", label).q[:, 3]))) for label in ("SRIM", "ESRIM")}
    assert turns["SRIM"] > 20
    assert turns["ESRIM"] <= 1


@pytest.mark.parametrize("name", PAST)
def test_the_error_settles_at_the_lag_law(name):
    """(α₀ − K_i)/K_p · 0.05 mm = 0.280 mm, whatever the step, for gains per mm."""
    assert_allclose(np.median(run(name, "ESRIM").position_error), LAG, atol=3e-6)


@pytest.mark.parametrize("name", PAST)
def test_lyapunovs_function_rises_least_with_esrim_but_it_does_rise(name):
    """ΔV < 0 throughout, as the paper has it, is impossible for a run that begins without error: V must rise first."""
    rises = {label: np.diff(lyapunov(run(name, label))).max() for label in ("SGIM", "SRIM", "ESRIM")}
    assert 0 < rises["ESRIM"] < 0.01
    assert rises["SGIM"] > 100 * rises["ESRIM"]
    assert rises["SRIM"] > 10 * rises["ESRIM"]


@pytest.mark.parametrize("label", ["SGIM", "SRIM", "ESRIM"])
def test_the_part_of_lyapunovs_derivative_that_feedback_makes_is_never_positive_for_any_of_them(label):
    """−K_p eᵀ J J* e: so its sign tells no method from another."""
    found = run("esrim_line", label)
    method = found.resolver.inverses[0]
    for q, error in zip(found.q[::20], found.error[::20]):
        J = found.robot.jacobian(q)
        closed = SCALE * (J @ method.solve(J, error))
        assert (SCALE * error) @ closed >= -1e-9 * np.linalg.norm(SCALE * error) ** 2


def test_the_tracking_loop_is_the_simulation_with_feed_forward():
    scenario = load_scenario("esrim_line")
    path, dt = rik.Line(scenario.motion.path(0.0), [0.3945, -0.3999, -0.4414], 0.005), scenario.dt
    motion = rik.Follow(path, gain=scenario.motion.gain, feedforward=True)
    inverse = Weighted(ESRIM(sigma0=1.3, alpha0=1.7), length_scale=1e-3)
    simulated = rik.simulate(scenario.robot, inverse, motion, scenario.q0, duration=5.0, dt=dt, limits=())
    loop = TrackingLoop(inverse, increment_gain=1.0, error_gain=motion.gain * dt)
    targets = [path(i * dt) for i in range(len(simulated.time))]
    robot = scenario.robot
    report = loop.run(
        targets, scenario.q0, forward=robot.pose, jacobian=robot.jacobian, difference=lambda a, b: rik.pose_error(b, a)
    )
    assert_allclose(report.q, simulated.q, atol=1e-9)
    assert_allclose(report.error, simulated.error, atol=1e-9)


def test_with_the_papers_own_step_the_line_is_passed_by_all_three():
    """Every point, 0.05 mm apart: here only coarser steps are thrown out of the tolerance."""
    fine = replace(load_scenario("esrim_line"), dt=0.01, duration=11.5)
    for label in ("SGIM", "SRIM"):
        passed = rik.simulate(fine, label)
        assert passed.time[np.argmin(passed.sigma[:, -1])] == pytest.approx(10.3, abs=0.1)
        assert passed.position_error.max() < TOLERANCE
