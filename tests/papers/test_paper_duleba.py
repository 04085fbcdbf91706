"""Dułęba 2023: its simulation, its evaluation, and what of it does not hold as printed.

Checked elsewhere: eqs. (7), (16), (19), (25) to (31), (44), (46) in `test_evaluation`; (11) to (13) and (45) in
`test_other_inverses`; (22) with its two thresholds in `test_filters`; (32) to (35) and the start of the path in
`test_robot_tables`; the lost direction of section 6.4 in `test_explain`; the singularities of the PUMA 560 in
`test_singularity_atlas`.
"""

import itertools
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

import robust_ik as rik
from benchmarks.claims.duleba import axis_heights, meets_its_axis, sizes, three_revolute
from robust_ik.analysis.evaluation import DulebaMatched, compare_damping_and_clamp, normalise, safety_by_damping
from robust_ik.inverses import DampedLeastSquares, DulebaAdditive, DulebaClamp
from robust_ik.kinematics.svd import lost_directions, svd
from robust_ik.simulation.scenarios import load_scenario, reach_points

AXIS = load_scenario("duleba_axis")
ARM = AXIS.robot
OTHER_ELBOW = np.radians([300, 191.9122981579187, -81.56619590206323])
A1, A2, A3 = 0.3, 0.2, 0.3
FLOOR, DETECT, DELTA = 1e-2, 1e-3, 1e-9
BOTH = ("Algorithm 1", "Algorithm 2")


@cache
def follow(label, cap, points=11, step=1.0, elbow=1):
    """Path (37) at equally many times in [0, 2], every point to δ or to the cap."""
    scenario = AXIS if elbow == 1 else replace(AXIS, q0=OTHER_ELBOW)
    times = tuple(np.linspace(0, 2, points))
    return reach_points(scenario, label, times, step=step, tolerance=DELTA, max_iterations=cap)


def second_sigma(result):
    return svd(ARM.jacobian(result.path)).s[:, 1]


# ------------------------------------------------------------------------------------------------ the path
def test_every_point_of_the_path_is_reached_in_a_singular_configuration_and_the_last_one_has_corank_2():
    results = follow("Algorithm 2", 2000)
    for t, found in zip(np.linspace(0, 2, 11), results):
        assert_allclose(ARM.pose(found.q)[:3, 3], [0, 0, (0.6 + 0.2 * t) * 0.4], atol=DELTA)
        assert abs(np.linalg.det(ARM.jacobian(found.q))) < 1e-10
        assert svd(ARM.jacobian(found.q)).corank(DETECT) == (2 if t == 2 else 1)
    assert_allclose(svd(ARM.jacobian(results[-1].q)).s, [0.5831, 0, 0], atol=1e-4)


@pytest.mark.parametrize("elbow", [1, -1])
def test_figure_3_q2_and_q3_end_stretched_and_q1_stays_at_300_degrees(elbow):
    for label in BOTH:
        q = np.degrees([found.q for found in follow(label, 2000, elbow=elbow)])
        assert_allclose(q[:, 0], 300, atol=1e-9)
        assert_allclose(q[0, 1:], [90.768, 81.566] if elbow == 1 else [191.912, -81.566], atol=1e-3)
        assert_allclose(q[-1, 1:], [126.870, 0], atol=0.11)
        assert (np.diff(elbow * q[:, 2]) < 0).all()


@pytest.mark.parametrize("elbow", [1, -1])
def test_both_algorithms_reach_all_other_points_in_a_few_iterations(elbow):
    for label, most in zip(BOTH, (8, 4)):
        before = follow(label, 2000, elbow=elbow)[:-1]
        assert all(found.converged for found in before)
        assert max(found.iterations for found in before) <= most


def test_the_two_trajectories_are_the_same_but_for_the_last_point():
    one, two = (np.array([found.q for found in follow(label, 2000)]) for label in BOTH)
    # q is known to about the square root of δ where the arm is nearly stretched.
    assert np.abs(one - two)[:-1].max() < 1e-6
    assert np.degrees(np.abs(one - two)[-1].max()) < 0.1


# ------------------------------------------------------------------------------------------------ its last point
def test_algorithm_2_reaches_the_end_in_1499_iterations_and_its_error_falls_as_their_square():
    end = follow("Algorithm 2", 2000)[-1]
    assert end.converged
    assert abs(end.iterations - 1499) <= 2
    n = np.array([300, 600, 1200])
    assert_allclose(end.errors[n] * n**2, 2.2e-3, rtol=0.05)
    # (L² + a3²)/(κL²) · d_min²/N², with L = a2 + a3 and the radius L − κ q3², κ = a2 a3/(2L).
    L, kappa = A2 + A3, A2 * A3 / (2 * (A2 + A3))
    assert_allclose(end.errors[1400] * 1400**2, (L**2 + A3**2) / (kappa * L**2) * FLOOR**2, rtol=0.03)


@pytest.mark.slow
def test_algorithm_1_does_not_and_its_error_falls_as_one_over_the_iterations():
    end = follow("Algorithm 1", 10_000)[-1]
    assert end.status is rik.NewtonStatus.ITERATION_LIMIT
    n = np.array([1000, 3000, 10_000])
    assert_allclose(end.errors[n] * n, 3.78e-4, rtol=2e-3)
    # λ (L² + a3²)/(2 L a2 a3)/N with L = a2 + a3 and λ = 2 d_min²/3, both small σ being far below the floor.
    L, squared = A2 + A3, 2 * FLOOR**2 / 3
    assert_allclose(end.errors[10_000] * 10_000, squared * (L**2 + A3**2) / (2 * L * A2 * A3), rtol=2e-3)


def test_the_law_goes_on_where_a_hundred_thousand_iterations_would_lead():
    """Begun as near as they would come, 3.8e-9, the next 500 lower the error as the law says: it is no floor."""
    q3 = np.sqrt(3.78e-9 / 0.06)
    q2 = np.arccos(-A1 / (A2 + A3)) - np.arctan2(A3 * np.sin(q3), A2 + A3 * np.cos(q3))
    near = replace(AXIS, q0=np.array([np.radians(300), q2, q3]))
    (found,) = reach_points(near, "Algorithm 1", [2.0], max_iterations=500)
    assert_allclose(found.errors[0], 3.8e-9, rtol=0.01)
    assert_allclose(np.diff(1 / found.errors[[0, 500]]), 500 / 3.78e-4, rtol=0.01)


@pytest.mark.parametrize("points", [3, 6, 11, 21, 41])
def test_the_distance_at_which_algorithm_1_is_said_to_stop_is_where_it_notices_corank_2(points):
    """5.6e-6 is the error of its first iterate with d₂ < 10⁻³, the detection threshold, however dense the path is."""
    end = follow("Algorithm 1", 200, points=points)[-1]
    first = int(np.argmax(second_sigma(end) < DETECT))
    assert 66 <= first <= 70
    assert_allclose(end.errors[first], 5.6e-6, atol=0.05e-6)
    # It does not stop there.
    assert end.errors[200] < end.errors[first] / 2.5


def test_no_one_budget_lets_algorithm_2_arrive_and_stops_algorithm_1_at_that_distance():
    one, two = follow("Algorithm 1", 2000)[-1], follow("Algorithm 2", 2000)[-1]
    budget = int(np.argmax(one.errors < 5.65e-6))
    assert budget < 100
    assert two.errors[budget] > 100 * DELTA
    assert one.errors[two.iterations] < 5.6e-6 / 20


def test_half_the_step_takes_twice_the_iterations():
    n = np.array([100, 200])
    for label, power in zip(BOTH, (1, 2)):
        whole, half = (follow(label, 400, step=step)[-1].errors for step in (1.0, 0.5))
        assert_allclose(half[2 * n], whole[n], rtol=0.05 * power)


def test_two_thresholds_hardly_change_the_end():
    """Acting on σ < 10⁻³ and raising it to 10⁻², as the data of section 5 say, instead of raising all below 10⁻²."""
    both = DulebaClamp(FLOOR, detect=DETECT)
    end = reach_points(AXIS, both, tuple(np.linspace(0, 2, 11)), max_iterations=2000)[-1]
    assert end.converged
    assert abs(end.iterations - 1481) <= 2


# ------------------------------------------------------------------------------------------------ evaluation
@pytest.mark.parametrize("m, c", [(m, c) for m in range(2, 7) for c in range(1, m + 1)])
def test_the_advantage_of_the_clamp_is_one_minus_c_over_m(m, c):
    """The remark below (31), at exact corank c: h₂ − h₁ = (1 − c/m) d_min², nothing for c = m."""
    s = np.append(np.ones(m - c), np.zeros(c))
    both = compare_damping_and_clamp(np.diag(s), FLOOR)
    assert_allclose(both.clamped - both.damped, (1 - c / m) * FLOOR**2, atol=1e-18)


def test_equal_safety_in_place_of_equal_modification_turns_the_verdict_round():
    """With λ = d_min² the smallest eigenvalue is at least the clamp's, and joint speeds are at most half as high."""
    s = np.append(np.ones((200, 2)), np.geomspace(1e-5, 1, 200)[:, None], axis=1)
    equal = DampedLeastSquares(FLOOR)
    assert (safety_by_damping(s, FLOOR**2) >= FLOOR**2).all()
    assert_allclose(equal.gains(s)[:, -1].max(), 0.5 / FLOOR, rtol=1e-2)
    assert_allclose(DulebaClamp(FLOOR).gains(s)[:, -1].max(), 1 / FLOOR, rtol=1e-12)


def test_bound_41_is_met_by_the_clamp_and_missed_by_the_damping_that_is_matched_with_it():
    s = np.append(np.ones((2000, 2)), np.geomspace(1e-5, 1, 2000)[:, None], axis=1)
    assert DulebaClamp(FLOOR).gains(s).max() <= 1 / FLOOR
    assert_allclose(DulebaMatched(FLOOR).gains(s).max() * FLOOR, 3 / (2 * np.sqrt(2)), rtol=1e-5)


def test_the_additive_inverse_is_equation_24_with_the_transpose_that_23_lost(rng):
    """Jᵀ(M + λI)⁻¹ through M + λI = U (D² + λI) Uᵀ; with U in place of Uᵀ, as printed, it is another one."""
    J, xdot = rng.normal(size=(3, 4)), rng.normal(size=3)
    U, s = svd(J).U, svd(J).s
    qdot = DulebaAdditive(0.01, "plain").solve(J, xdot)
    assert_allclose(J.T @ U @ np.diag(1 / (s**2 + 0.01)) @ U.T @ xdot, qdot, atol=1e-12)
    for signs in itertools.product([1, -1], repeat=3):  # which the columns of U have is the SVD's choice
        printed = U * signs
        assert np.abs(J.T @ printed @ np.diag(1 / (s**2 + 0.01)) @ printed @ xdot - qdot).max() > 0.1


def test_the_safety_of_a_sum_may_exceed_the_sum_of_safeties_so_it_is_no_norm():
    """(38): both matrices are singular, their sum is the identity."""
    A, B = np.diag([1.0, 0]), np.diag([0, 1.0])
    safeties = [safety_by_damping(svd(each).s, 0.0) for each in (A, B, A + B)]
    assert_allclose(safeties, [0, 0, 1], atol=1e-15)


def test_along_the_weakest_direction_joints_move_by_one_over_its_singular_value_and_the_clamp_bounds_that():
    """(40) and (41)."""
    J = ARM.jacobian(np.array([0.3, 0.4, 0.002]))
    U, s = svd(J).U, svd(J).s
    assert s[-1] < FLOOR / 10
    assert_allclose(np.linalg.norm(rik.MoorePenrose().solve(J, U[:, -1])), 1 / s[-1], rtol=1e-9)
    assert_allclose(np.linalg.norm(DulebaClamp(FLOOR).solve(J, U[:, -1])), 1 / FLOOR, rtol=1e-9)


def test_normalised_kinematics_depend_less_on_the_lengths_and_not_at_all_on_the_size():
    """Section 6.3, rows divided by their bounds of (46)."""
    raw, normalised = sizes()
    assert raw > 50
    assert normalised < 1.5
    q = np.array([0.3, 0.4, 1.2])
    small, large = (three_revolute(size * np.array([A1, A2, A3])) for size in (0.1, 10.0))
    extents = np.array([A1 + A2 + A3, A1 + A2 + A3, A2 + A3])
    one, other = (normalise(each.jacobian(q), size * extents) for each, size in ((small, 0.1), (large, 10.0)))
    assert_allclose(one, other, atol=1e-12)


# ------------------------------------------------------------------------------------------------ where A = 0
@pytest.mark.parametrize("a1", [0.45, 0.499, 0.501, 0.6])
def test_condition_36_says_which_arms_reach_their_axis(a1):
    assert meets_its_axis(three_revolute((a1, A2, A3))) == (a1 <= A2 + A3)


def test_the_printed_range_of_z_is_that_of_the_papers_lengths_and_has_a_hole_for_unequal_links():
    """All of it is reached only if |a₂ − a₃| ≤ a₁, as with the paper's lengths."""
    z = np.sort(axis_heights(ARM))
    assert_allclose([z[0], z[-1]], [-0.4, 0.4], atol=1e-4)
    assert np.diff(z).max() < 0.01
    unequal = np.abs(axis_heights(three_revolute((0.1, 0.2, 0.5))))
    assert_allclose([unequal.min(), unequal.max()], np.sqrt([0.3**2 - 0.1**2, 0.7**2 - 0.1**2]), atol=2e-4)


# ------------------------------------------------------------------------------------------------ directions
def test_on_the_way_only_the_sideways_direction_is_lost_and_the_path_needs_none_of_it():
    for found in follow("Algorithm 2", 2000)[:-1]:
        J, q1 = ARM.jacobian(found.q), found.q[0]
        lost = lost_directions(J, DETECT)
        assert lost.shape == (3, 1)
        assert abs(lost[:, 0] @ [np.sin(q1), -np.cos(q1), 0]) > 1 - 1e-9
        assert rik.unavoidable_angle(J, [0.0, 0, 1], DETECT) < 1e-6


def test_at_the_end_one_direction_is_left_and_the_path_is_53_degrees_from_it():
    q = np.array([np.radians(300), np.arccos(-A1 / (A2 + A3)), 0])
    J = ARM.jacobian(q)
    U = svd(J).U[:, 0]
    left = np.array([0.8 * np.cos(q[0]), 0.8 * np.sin(q[0]), 0.6])
    assert_allclose(abs(U @ left), 1, rtol=1e-12)
    assert_allclose(rik.unavoidable_angle(J, [0.0, 0, 1], DETECT), np.arccos(0.6), rtol=1e-12)


# ------------------------------------------------------------------------------------------------ PUMA 560
@cache
def puma(which, label):
    return rik.simulate(load_scenario(f"puma_{which}"), label)


ROBUST = (*BOTH, "(11), λ = d_min²", "(12), λ = 0.001")


@pytest.mark.parametrize("which", ["wrist", "shoulder"])
def test_the_puma_passes_its_singularities_and_equal_safety_is_calmer_than_the_clamp_and_that_than_its_match(which):
    runs = [puma(which, label) for label in ROBUST]
    for run in runs:
        assert run.smallest_sigma < FLOOR
        assert np.linalg.norm(run.final_error) < 1e-6
    one, two, equal, _ = (run.largest_speed for run in runs)
    assert two < one
    assert equal < 0.6 * two


@pytest.mark.slow
def test_the_puma_held_out_of_reach_shakes_with_a_floor_of_a_hundredth_and_with_any_clamp():
    """φ(0⁺) = 1/d_min and, for the others, φ′(0) too large for 10 ms: none rests. A larger damping does."""

    def resting(method):
        run = rik.simulate(load_scenario("puma_elbow"), method)
        return np.abs(run.qdot[run.time > 7]).max()

    one, two, equal, scaled = (resting(label) for label in ROBUST)
    assert min(one, two, equal, scaled) > 5
    assert equal < 0.6 * two < 0.6 * one
    assert resting(DampedLeastSquares(0.2)) < 0.1
    assert resting(DulebaClamp(0.2)) > 1
