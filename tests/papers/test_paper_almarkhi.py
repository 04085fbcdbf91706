"""Almarkhi and Maciejewski 2019: the numbers of the paper, and those that show where it is wrong.

Elsewhere: Tables 3, 4, Figure 9, the lattice of right angles and the arm of Table 1 in test_robot_tables, the atlas of
the PA-10 and its certificates in test_singularity_atlas and test_certificates, the lost wrenches and the arm of section
2.3 in test_singular_directions, gradients of σ against differences in test_derivatives.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import minimize

import robust_ik as rik
from benchmarks.claims.almarkhi import (
    FIG_1,
    FIG_2,
    FIG_3,
    FIG_6,
    ROTATED,
    SUBSPACE,
    chain,
    cosines,
    derivatives,
    lost_by_figure_6,
    starts,
)
from robust_ik.description.catalog import find
from robust_ik.display import descents_figure
from robust_ik.kinematics.singular_value_gradients import closed_form_hessian
from robust_ik.singularities.find.find_points import find_points
from robust_ik.singularities.find.gradient_history import gradient_descent
from robust_ik.singularities.find.gradient_search import Slope, gradient_search
from robust_ik.singularities.find.projection_search import project, project_by_numpy
from robust_ik.singularities.find.rank_residual import Residual
from robust_ik.singularities.geometry.screw_chain import ScrewChain
from robust_ik.singularities.lost_motion.sparse_basis import sparse_basis

PI = np.pi


def table(name):
    return rik.read_dh(find(name).path)


# ------------------------------------------------------------------------------------------ the derivative of J
@cache
def forms():
    return derivatives(200)


def random_arm(seed):
    rng = np.random.default_rng(seed)
    lengths, angles = rng.uniform(0.1, 0.5, (7, 2)), rng.uniform(-PI, PI, 7)
    joints = [rik.DHJoint(a=a, d=d, alpha=alpha) for (a, d), alpha in zip(lengths, angles)]
    return rik.DHTable(tuple(joints), "standard")


def axes_and_arms(dh, q):
    frames = dh.frames(q)
    return frames[:, :-1, :3, 2], frames[:, -1:, :3, 3] - frames[:, :-1, :3, 3]


def test_with_p_i_equation_9_is_the_derivative_of_the_jacobian_and_as_printed_it_is_not():
    _, difference, right, printed = forms()
    assert_allclose(right, difference, rtol=0, atol=1e-9)
    assert np.abs(printed - difference).max() > 0.6


@pytest.mark.parametrize("seed", range(3))
def test_the_same_on_an_arm_without_special_angles(seed):
    dh = random_arm(seed)
    q = np.random.default_rng(seed).uniform(-PI, PI, (20, 7))
    z, arms = axes_and_arms(dh, q)
    H = rik.Robot.from_dh(dh).hessian(q)
    assert_allclose(closed_form_hessian(z, arms), H, rtol=0, atol=1e-12)
    assert np.abs(closed_form_hessian(z, arms, printed=True) - H).max() > 0.5


def test_the_printed_branch_errs_by_the_distance_of_the_frames_times_the_cosine_of_the_axes():
    q = rik.load("pa10").random(np.random.default_rng(0), 50)
    z, arms = axes_and_arms(table("pa10"), q)
    error = closed_form_hessian(z, arms, printed=True) - closed_form_hessian(z, arms)
    for i in range(7):
        for k in range(7):
            apart = arms[:, i] - arms[:, k]  # o_k − o_i
            expected = np.sum(z[:, k] * z[:, i], axis=1, keepdims=True) * apart if k < i else 0 * apart
            assert_allclose(error[:, :3, i, k], expected, atol=1e-12)
    assert_allclose(error[:, 3:], 0, atol=0)


def test_the_linear_block_is_symmetric_and_the_angular_one_is_zero_for_later_joints():
    _, _, right, _ = forms()
    assert_allclose(right[:, :3], right[:, :3].swapaxes(-1, -2), atol=1e-12)
    later = np.arange(7)[None, :] >= np.arange(7)[:, None]
    assert_allclose(right[:, 3:, later], 0, atol=0)


def test_the_printed_form_leads_uphill_at_some_configurations_and_the_right_one_nowhere():
    J, difference, right, printed = forms()
    assert cosines(J, difference, right).min() > 1 - 1e-6
    wrong = cosines(J, difference, printed)
    assert 0.1 < np.median(wrong) < 0.5
    assert 0.1 < np.mean(wrong < 0) < 0.3
    # (−∇σ6 of the printed form) raises σ6 where the cosine is negative.
    worst = wrong.argmin()
    assert wrong[worst] < -0.3


def test_the_closed_form_takes_axes_and_arms_of_one_shape_only():
    with pytest.raises(rik.InputError, match="must have the same shape"):
        closed_form_hessian(np.ones((7, 3)), np.ones((6, 3)))


# ------------------------------------------------------------------------------------------ figures 1 to 3
@cache
def plain():
    return gradient_descent(chain(), 2, starts()[FIG_1[0]], step=FIG_1[1], max_iterations=1600)


@cache
def stuck():
    return gradient_descent(chain(), 3, starts()[FIG_2[0]], step=FIG_2[1], max_iterations=1000)


def test_figure_1_where_the_two_values_meet_the_gradient_turns_from_step_to_step():
    run, turns = plain(), np.degrees(plain().turns)
    met = int(np.argmax(run.weakest[:, 1] > 0.98 * run.weakest[:, 0]))
    assert 600 < met < 900
    assert turns[: met - 20].max() < 5
    assert np.mean(turns[met + 30 : met + 300] > 45) > 0.3
    # A fixed step bounces off σ = 0, half a turn each time: when it comes below ε is luck.
    assert turns[met:].max() > 170
    assert run.weakest[met : met + 300, 0].min() > 1e-4


def test_figure_2_where_three_values_are_near_the_gradient_turns_and_the_first_hardly_falls():
    run = stuck()
    assert np.degrees(run.turns.max()) > 100
    assert not run.converged
    assert run.weakest[:, 0].min() > 0.25
    assert run.weakest[800, 2] > 0.9 * run.weakest[800, 0]


def test_figure_3_rotating_clusters_saves_steps():
    rotated, alone = (gradient_descent(chain(), 3, starts()[FIG_3], rotated=each) for each in (True, False))
    assert rotated.converged
    assert 16 < len(rotated) < len(alone)
    assert rotated.weakest[-1, 0] <= 1e-6
    # The best step along a gradient ends where the next one is across it.
    assert 75 < np.degrees(rotated.turns.mean()) < 110


def test_rotation_may_find_no_descent_where_there_is_one():
    """The entries of uₐᵀ(∂J/∂q)v_b beside the diagonal count as well; the projection gets on."""
    run = gradient_descent(chain(), 3, starts()[FIG_2[0]])
    assert not run.converged
    assert len(run) < 20
    block = Slope.at(chain(), run.values[-1:], 3).block[0, :2, :2]
    block = (block + block.transpose(1, 0, 2)) / 2
    mean, half, beside = (block[0, 0] + block[1, 1]) / 2, (block[0, 0] - block[1, 1]) / 2, block[0, 1]
    # The shortest of all derivatives of uᵀJv with unit pairs of the cluster, and means of them: if it is not zero,
    # σ4 falls against it.
    radius, turn = np.meshgrid(np.linspace(0, 1, 51), np.linspace(0, 2 * PI, 181))
    every = mean + np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=-1).reshape(-1, 2) @ [half, beside]
    shortest = every[np.linalg.norm(every, axis=1).argmin()]
    assert np.linalg.norm(shortest) > 0.03
    q = run.values[-1] - 0.01 * shortest / np.linalg.norm(shortest)
    after = np.linalg.svd(chain().jacobian(q), compute_uv=False)[3]
    assert after < run.weakest[-1, 0] - 1e-4
    assert project(chain(), 3, starts()[FIG_2[0]][None]).converged.all()


def test_descents_are_recorded_from_their_start_and_stop_at_epsilon():
    run = gradient_descent(chain(), 1, starts()[0])
    assert_allclose(run.values[0], starts()[0], atol=0)
    assert run.s.shape == (len(run) + 1, 6)
    assert run.converged
    assert (np.diff(run.weakest[:, 0]) < 0).all()
    assert_allclose(gradient_descent(chain(), 1, run.values[-1]).values, run.values[-1:], atol=0)
    with pytest.raises(rik.InputError, match="one configuration"):
        gradient_descent(chain(), 1, starts()[:2])
    with pytest.raises(rik.InputError, match="step must be"):
        gradient_descent(chain(), 1, starts()[0], step=0.0)


def test_the_figure_of_descents_has_two_panels_for_each():
    runs = {"one": stuck(), "two": gradient_descent(chain(), 1, starts()[0])}
    figure = descents_figure(runs)
    assert len(figure.axes) == 4
    assert [len(axes.lines) for axes in figure.axes] == [3, 2, 1, 1]  # the red ε where it was reached
    with pytest.raises(rik.InputError, match="nothing to draw"):
        descents_figure({})


# ------------------------------------------------------------------------------------------ success of the searches
@cache
def search(corank, rotated, count=40):
    return gradient_search(chain(), corank, starts()[:count], rotated=rotated)


def test_the_gradient_alone_reaches_corank_1_always_2_sometimes_3_seldom():
    counts = [int(search(corank, False).converged.sum()) for corank in (1, 2, 3)]
    assert counts[0] == 40
    assert 8 <= counts[1] <= 26
    assert 2 <= counts[2] <= 12
    one, three = search(1, False), search(3, False)
    assert np.median(one.tries) <= 4
    # What is not reached is not nearly reached.
    assert 0.01 < np.median(three.residual.s[:, 3]) < 0.1


def test_rotating_clusters_helps_and_does_not_suffice():
    for corank, most in ((2, 0.7), (3, 0.4)):
        assert search(corank, True).converged.mean() < most
    # Which starts it saves hangs on rounding, that it saves some does not.
    alone, rotated = (sum(int(search(k, each).converged.sum()) for k in (2, 3)) for each in (False, True))
    assert alone < rotated


@pytest.mark.parametrize("corank, least, steps", [(1, 1.0, 5), (2, 1.0, 6), (3, 0.88, 10)])
def test_projection_without_second_tries_reaches_every_corank_in_a_few_steps(corank, least, steps):
    found = project(chain(), corank, starts())
    assert found.converged.mean() >= least
    assert np.median(found.tries[found.converged]) <= steps


def test_projection_with_pushes_reaches_corank_3_from_every_start_and_corank_4_from_none():
    rng = np.random.default_rng(2)
    assert find_points(chain(), 3, starts(), rng, measured=False).success >= 0.99
    assert find_points(chain(), 4, starts()[:60], rng, measured=False).success == 0


def test_without_the_null_space_fewer_starts_lead_to_coranks_1_and_2(monkeypatch):
    whole = Residual.by_numpy

    def reduced(its, values, corank):
        at = whole(its, values, corank)
        blocks = at.derivative.reshape(len(values), corank, -1, its.n)
        return replace(at, derivative=blocks[:, :, :corank].reshape(len(values), corank**2, its.n))

    monkeypatch.setattr(Residual, "by_numpy", reduced)
    shares = [project_by_numpy(chain(), corank, starts()).converged.mean() for corank in (1, 2)]
    assert max(shares) < 0.99


@pytest.mark.parametrize("corank, most", [(1, 25), (2, 45), (3, 70)])
def test_the_sum_of_squares_of_the_weakest_values_is_smooth_enough_for_bfgs(corank, most):
    def objective(q):
        slope = Slope.at(chain(), q[None], corank)
        gradients = np.einsum("aak->ak", slope.block[0])
        return 0.5 * np.sum(slope.weakest**2), slope.weakest[0] @ gradients

    runs = [minimize(objective, q, jac=True, method="BFGS", options={"gtol": 1e-10}) for q in starts()[:15]]
    assert sum(np.sqrt(2 * run.fun) < 1e-6 for run in runs) >= 14
    assert np.median([run.nit for run in runs]) <= most


# ------------------------------------------------------------------------------------------ section 2.3
def test_both_printed_matrices_span_one_subspace():
    one, other = (np.linalg.qr(each)[0] for each in (SUBSPACE, ROTATED))
    assert np.linalg.svd(one.T @ other, compute_uv=False).min() > 0.9995


def test_quartimax_turns_the_printed_subspace_into_the_printed_directions():
    basis = np.linalg.qr(SUBSPACE)[0]
    found = sparse_basis(basis)
    expected = np.zeros((6, 3))  # (.912 v_y, .410 w_z), (.912 v_z, −.410 w_y), w_x
    expected[[1, 5], 0], expected[[2, 4], 1], expected[3, 2] = (0.912, 0.41), (0.912, -0.41), 1
    assert_allclose(found, expected, rtol=0, atol=0.01)
    assert_allclose(expected[[1, 5], 0], np.array([1, 0.45]) / np.hypot(1, 0.45), rtol=0, atol=5e-4)
    assert_allclose(abs(np.linalg.det(basis.T @ found)), 1, atol=1e-9)


def test_the_result_does_not_hang_on_the_basis_that_the_svd_happens_to_give(rng):
    basis = np.linalg.qr(SUBSPACE)[0]
    found = sparse_basis(basis)
    for _ in range(50):
        turned = basis @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
        assert_allclose(sparse_basis(turned), found, atol=1e-8)


def test_the_example_is_not_the_arm_of_table_2_which_loses_pure_directions_at_zero():
    lost = sparse_basis(rik.lost_directions(rik.load("pa10").jacobian(np.zeros(7))))
    assert_allclose(lost, np.eye(6)[:, 1:4], atol=1e-12)


# ------------------------------------------------------------------------------------------ the 4-DoF arm
def test_under_modified_dh_the_printed_configurations_are_not_singular():
    arm = rik.Robot.from_dh(replace(table("almarkhi_4dof"), convention="modified"))
    sigma = [rik.svd(arm.jacobian(q)).s[2] for q, _ in FIG_6]
    assert_allclose(sigma, [0.09, 0.80], rtol=0, atol=0.005)


@pytest.mark.parametrize("index, sigma, u, off", [
    (0, 0.0024, (-0.183, 0.969, -0.167), 14.4), (1, 0.0050, (-0.987, 0.157, 0.024), 9.2),
])  # fmt: skip
def test_the_directions_of_figure_6_are_rounded_to_whole_numbers(index, sigma, u, off):
    here, away, lost, angle = lost_by_figure_6(index)
    assert_allclose([here, away], sigma, rtol=0, atol=5e-5)
    assert_allclose(lost, u, rtol=0, atol=1e-3)
    assert_allclose(angle, off, rtol=0, atol=0.1)


@pytest.mark.parametrize("index, least", [(0, 13.5), (1, 8.5)])
def test_no_angles_that_round_to_the_printed_ones_give_the_printed_direction(index, least, rng):
    q, u = FIG_6[index]
    around = np.array(q) + rng.uniform(-0.005, 0.005, (2000, 4))
    lost = rik.svd(rik.load("almarkhi_4dof").jacobian(around)).U[:, :, 2]
    assert np.degrees(np.arccos(np.abs(lost @ u))).min() > least


def test_every_start_leads_the_4dof_arm_to_corank_1():
    points = find_points(ScrewChain.of(rik.load("almarkhi_4dof")), 1, 1000, measured=False)
    assert points.success == 1
    assert (points.coranks == 1).all()


def test_the_second_singular_value_of_the_4dof_arm_has_a_floor(rng):
    robot = rik.load("almarkhi_4dof")
    begin = robot.random(rng, 2000)
    lowest = begin[rik.svd(robot.jacobian(begin)).s[:, 1].argsort()[:5]]
    options = {"xatol": 1e-9, "fatol": 1e-12, "maxiter": 2000}
    runs = [
        minimize(lambda q: rik.svd(robot.jacobian(q)).s[1], q, method="Nelder-Mead", options=options) for q in lowest
    ]
    assert_allclose(min(run.fun for run in runs), 0.709, rtol=0, atol=1e-3)


# ------------------------------------------------------------------------------------------ the PA-10
def test_table_5_cannot_leave_theta_3_free(rng):
    robot = rik.load("pa10")
    right = np.stack(np.meshgrid(*[[0, PI / 2, PI, -PI / 2]] * 4), axis=-1).reshape(-1, 4)
    for q3 in rng.uniform(0.1, PI - 0.1, 10):
        q = np.zeros((len(right), 7))
        q[:, [1, 3, 4, 5]], q[:, 2] = right, q3
        assert np.sum(rik.svd(robot.jacobian(q)).s < 1e-9, axis=1).max() == 2
    whole = np.array([0.4, PI, 0, 0, PI, 0, -1.1])
    assert np.sum(rik.svd(robot.jacobian(whole)).s < 1e-9) == 3


def test_under_modified_dh_table_3_would_not_be_minimal(rng):
    """Then q2 = 0 alone would be singular."""
    joints = table("pa10")
    for convention, corank in (("standard", 0), ("modified", 1)):
        q = rng.uniform(-PI, PI, (20, 7))
        q[:, 1] = 0
        s = rik.svd(rik.Robot.from_dh(replace(joints, convention=convention)).jacobian(q)).s
        assert (np.sum(s < 1e-9, axis=1) == corank).all(), convention


def test_coranks_do_not_depend_on_the_hand_and_singular_values_do(rng):
    joints = table("pa10")
    short = rik.Robot.from_dh(replace(joints, joints=(*joints.joints[:6], replace(joints.joints[6], d=0.1))))
    right = rng.choice([0, PI / 2, PI, -PI / 2, 0.7], (200, 7))
    s, other = (rik.svd(robot.jacobian(right)).s for robot in (rik.load("pa10"), short))
    assert (np.sum(s < 1e-9, axis=1) == np.sum(other < 1e-9, axis=1)).all()
    assert np.abs(s - other).max() > 0.1
