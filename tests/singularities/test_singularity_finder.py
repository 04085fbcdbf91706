"""The search for singular configurations, and the kinematics that carry it."""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import robust_ik as rik
from robust_ik.description.catalog import catalog
from robust_ik.kinematics.svd import full_svd
from robust_ik.singularities.find.find_points import find_points, local_dimensions, project
from robust_ik.singularities.find.gradient_clusters import rotated_gradients
from robust_ik.singularities.find.points_found import Points
from robust_ik.singularities.find.rank_residual import Residual, coranks, ranks
from robust_ik.singularities.geometry.screw_chain import ScrewChain
from tests.robot.test_robot import EXAMPLE_NAMES, WITHOUT_JOINTS, chains

OURS = [name for name, entry in catalog().items() if entry.source == "robust_ik"]
PAIRS = [
    ("pa10", 1), ("pa10", 2), ("pa10", 3), ("panda", 1), ("panda", 2), ("puma560", 1), ("puma560", 2), ("ur5", 1),
    ("ur5", 2), ("ur5", 3), ("almarkhi_4dof", 1), ("duleba_3r", 1), ("duleba_3r", 2), ("kinova", 1), ("tiago", 1),
]  # fmt: skip


@cache
def chain(name, **options):
    return ScrewChain.of(rik.load(name), **options)


@cache
def found(name, corank, starts=300):
    return find_points(chain(name), corank, starts, np.random.default_rng(1))


# ------------------------------------------------------------------------------------------ kinematics
@pytest.mark.parametrize("name", sorted(set(EXAMPLE_NAMES) - WITHOUT_JOINTS))
def test_jacobian_and_hessian_of_every_example_chain_are_the_robots(name, rng):
    for robot in chains(name):
        its = ScrewChain.of(robot)
        values = its.random(rng, 2)
        q = robot.configuration(values)
        assert_allclose(its.jacobian(values), robot.jacobian(q), atol=1e-12, err_msg=str(robot))
        assert_allclose(its.hessian(values), robot.hessian(q), atol=1e-12, err_msg=str(robot))


@pytest.mark.parametrize("name", OURS)
def test_jacobian_and_hessian_of_our_robots_are_the_robots_in_their_rows(name, rng):
    robot = rik.load(name)
    values = chain(name).random(rng, 3)
    q = robot.configuration(values)
    assert chain(name).rows == robot.rows
    assert_allclose(chain(name).jacobian(values), robot.jacobian(q), atol=1e-12)
    assert_allclose(chain(name).hessian(values), robot.hessian(q), atol=1e-12)


def test_rows_and_length_scale_choose_and_divide(rng):
    robot, rows = rik.load("tiago"), ("wz", "x", "z")
    its = ScrewChain.of(robot, rows=rows, length_scale=0.4)
    values = its.random(rng, 3)
    q, weight = robot.configuration(values), np.array([1, 1 / 0.4, 1 / 0.4])
    assert_allclose(its.jacobian(values), weight[:, None] * robot.jacobian(q, rows=rows), atol=1e-12)
    assert_allclose(its.hessian(values), weight[:, None, None] * robot.hessian(q, rows=rows), atol=1e-12)


def test_kinematics_take_any_leading_axes(rng):
    values = rng.uniform(-1, 1, (2, 3, 7))
    J, H = chain("panda").jacobian(values), chain("panda").hessian(values)
    assert J.shape == (2, 3, 6, 7)
    assert H.shape == (2, 3, 6, 7, 7)
    assert_allclose(J[1, 2], chain("panda").jacobian(values[1, 2]), atol=1e-14)
    assert_allclose(H[1, 2], chain("panda").hessian(values[1, 2]), atol=1e-14)


def test_a_contraction_is_the_hessian_between_vectors(rng):
    its = chain("panda")
    values, U, V = rng.uniform(-1, 1, (4, 7)), rng.normal(size=(4, 6, 2)), rng.normal(size=(4, 7, 3))
    expected = np.einsum("nia,nijk,njb->nabk", U, its.hessian(values), V)
    assert_allclose(its.contraction(values, U, V), expected, atol=1e-12)


@pytest.mark.parametrize("name", ["pa10", "kinova", "tiago", "planar_3r"])
def test_wrapping_changes_no_pose_and_no_sliding_joint(name, rng):
    robot, its = rik.load(name), chain(name)
    values = 5 * its.random(rng, 20)
    wrapped = its.wrapped(values)
    assert_allclose(robot.pose(robot.configuration(wrapped)), robot.pose(robot.configuration(values)), atol=1e-12)
    turning = np.isfinite(its.period)
    assert np.abs(wrapped[:, turning]).max() <= np.pi
    assert_array_equal(wrapped[:, ~turning], values[:, ~turning])


def test_sliding_joints_start_within_their_limits_and_others_anywhere(rng):
    robot, its = rik.load("tiago"), chain("tiago")
    values = its.random(rng, 1000)
    assert its.sliding[0]
    assert values[:, 0].min() >= robot.lower[0]
    assert values[:, 0].max() <= robot.upper[0]
    assert values[:, 1:].min() < -3
    assert values[:, 1:].max() > 3


def test_a_whole_tree_is_refused():
    with pytest.raises(rik.TipError, match="without a tip"):
        ScrewChain.of(rik.load("tiago", whole_tree=True))


# ------------------------------------------------------------------------------------------ the residual
@pytest.mark.parametrize("name, corank", [("pa10", 1), ("panda", 3), ("ur5", 2), ("tiago", 2), ("almarkhi_4dof", 1)])
def test_the_residuals_derivative_is_that_of_frozen_vectors(name, corank, rng):
    its, h = chain(name), 1e-6
    q = its.random(rng, 1)
    found = full_svd(its.jacobian(q))
    U2, V2 = found.U[0, :, its.m - corank :], found.Vt[0, its.m - corank :].T
    around = its.jacobian(q + h * np.vstack([np.eye(its.n), -np.eye(its.n)]))
    r = (U2.T @ around @ V2).reshape(2 * its.n, -1)
    at = Residual.at(its, q, corank)
    assert_allclose(at.derivative[0].T, (r[: its.n] - r[its.n :]) / (2 * h), atol=1e-8)
    assert_allclose(np.abs(at.vector[0]), np.abs((U2.T @ its.jacobian(q[0]) @ V2).ravel()), atol=1e-12)


def test_of_more_rows_than_joints_the_residual_holds_all_left_vectors_without_a_motion(rng):
    its, h = ScrewChain.of(rik.load("planar_3r").with_rows(("x", "y", "z", "wx", "wy", "wz"))), 1e-6
    q = its.random(rng, 1)
    for corank in (1, 2):
        found = full_svd(its.jacobian(q))
        U2, V2 = found.U[0, :, its.n - corank :], found.Vt[0, its.n - corank :].T
        around = its.jacobian(q + h * np.vstack([np.eye(its.n), -np.eye(its.n)]))
        r = np.swapaxes(U2.T @ around @ V2, 1, 2).reshape(2 * its.n, -1)
        difference = (r[: its.n] - r[its.n :]) / (2 * h)
        at = Residual.at(its, q, corank)
        assert at.derivative.shape == (1, corank * (its.m - its.n + corank), its.n)
        # The left vectors that no motion has are any basis: lengths do not hang on it.
        assert_allclose(np.linalg.norm(at.derivative[0], axis=0), np.linalg.norm(difference, axis=1), atol=1e-7)
        assert_allclose(np.linalg.norm(at.vector[0]), np.linalg.norm(U2.T @ its.jacobian(q[0]) @ V2), atol=1e-12)


@pytest.mark.parametrize(
    "name, corank", [("pa10", 2), ("ur5", 3), ("duleba_3r", 1), ("planar_3r", 2), ("planar_3r", 1)]
)
def test_the_residual_times_its_derivative_is_the_gradient_of_half_the_sum_of_squares(name, corank, rng):
    every = ("x", "y", "z", "wx", "wy", "wz")
    its = ScrewChain.of(rik.load(name).with_rows(every) if name == "planar_3r" else rik.load(name))
    q, h = its.random(rng, 1), 1e-6
    s = np.linalg.svd(its.jacobian(q + h * np.vstack([np.eye(its.n), -np.eye(its.n)])), compute_uv=False)
    half = 0.5 * np.sum(s[:, s.shape[1] - corank :] ** 2, axis=1)
    at = Residual.at(its, q, corank)
    assert_allclose(at.derivative[0].T @ at.vector[0], (half[: its.n] - half[its.n :]) / (2 * h), atol=1e-7)
    here = np.linalg.svd(its.jacobian(q[0]), compute_uv=False)
    assert_allclose(at.norm, np.linalg.norm(here[len(here) - corank :]), rtol=1e-9)
    assert_allclose(at.relative, at.norm / here[0], rtol=1e-9)


def test_ranks_are_clear_away_from_small_values_only():
    rank, clear = ranks(np.array([np.diag([1.0, 0.5, 1e-12]), np.diag([1.0, 5e-3, 1e-5]), np.zeros((3, 3))]))
    assert_array_equal(rank, [2, 2, 0])
    assert_array_equal(clear, [True, False, True])
    assert_array_equal(ranks(1e-5 * np.eye(3)[None], np.array([2.0]))[1], [False])


# ------------------------------------------------------------------------------------------ what is found
@pytest.mark.parametrize("name, corank", PAIRS)
def test_every_point_is_singular_by_pinocchios_jacobian(name, corank):
    points = found(name, corank)
    robot = rik.load(name)
    s = np.linalg.svd(robot.jacobian(robot.configuration(points.values)), compute_uv=False)
    assert len(points) > 0
    assert s[:, len(robot.rows) - corank].max() < 1e-10
    assert_array_equal(points.coranks, np.sum(s < 1e-6 * s[:, :1], axis=1))
    assert (points.coranks >= corank).all()
    assert points.residual.max() <= 1e-11


@pytest.mark.parametrize(
    "name, corank, least",
    [("pa10", 1, 1), ("pa10", 2, 1), ("pa10", 3, 0.99), ("panda", 1, 1), ("panda", 2, 0.65), ("puma560", 1, 1),
     ("puma560", 2, 1), ("ur5", 1, 1), ("ur5", 2, 1), ("ur5", 3, 0.99), ("almarkhi_4dof", 1, 1)],
)  # fmt: skip
def test_nearly_every_start_leads_to_a_point(name, corank, least):
    assert found(name, corank).success >= least


@pytest.mark.parametrize("name, corank", [("pa10", 4), ("panda", 3), ("puma560", 3), ("ur5", 4), ("almarkhi_4dof", 2)])
def test_where_there_is_no_such_corank_none_is_found_and_the_floor_says_how_near(name, corank):
    points = found(name, corank, 100)
    assert len(points) == 0
    assert points.success == 0
    assert points.values.shape == (0, chain(name).n)
    assert points.minima.shape == (points.failed, chain(name).n) == (100, chain(name).n)
    assert points.floors.min() > 1e-4


@pytest.mark.parametrize(
    "name, corank, dimensions",
    [("pa10", 1, {5, 6}), ("pa10", 2, {3, 4}), ("pa10", 3, {2}), ("puma560", 1, {5}), ("ur5", 1, {5}),
     ("panda", 1, {5}), ("almarkhi_4dof", 1, {2}), ("duleba_3r", 1, {2}), ("duleba_3r", 2, {1}), ("planar_2r", 1, {1})],
)  # fmt: skip
def test_dimensions_are_the_known_ones(name, corank, dimensions, rng):
    points = found(name, corank)
    assert set(points.dimensions[points.exact & ~points.folded]) == dimensions
    assert points.folded.mean() < 0.01
    some = np.flatnonzero(~points.folded)[:20]
    sampled = local_dimensions(chain(name), corank, points.values[some], rng)
    # PUMA 560's folded elbow passes its shoulder singularity at 2 mm: a sample may land on the other.
    assert np.mean(sampled == points.dimensions[some]) >= (0.8 if name == "puma560" else 1)


def test_every_stratum_of_the_pa10_is_met():
    def pinned(corank):
        points = found("pa10", corank, 600)
        values = points.values[~points.folded]
        return {tuple(1 + np.flatnonzero(row)) for row in np.abs(np.sin(2 * values)) < 1e-4}

    assert pinned(1) == {(4,), (2, 3), (2, 6), (5, 6)}
    assert pinned(2) == {(2, 3, 4), (2, 4, 6), (4, 5, 6), (2, 3, 5, 6)}
    assert pinned(3) == {(2, 3, 4, 5, 6)}


def test_a_point_where_strata_cross_is_led_away_from():
    its = chain("pa10")
    crossing = np.array([[0.3, 0.0, 1.0, 0.0, 0.8, 0.7, 0.1], [0.3, 0.0, np.pi / 2, 0.5, 0.8, 0.0, 0.1]])
    points = find_points(its, 1, crossing, np.random.default_rng(3))
    assert_array_equal(points.coranks, 1)
    assert not points.folded.any()


def test_a_point_of_higher_corank_is_led_away_from_where_possible():
    points = find_points(chain("pa10"), 1, np.zeros((5, 7)), np.random.default_rng(3))
    assert_array_equal(points.coranks, 1)


def test_a_stratum_of_higher_corank_that_stands_alone_is_reported_as_such():
    points = found("srs_7r", 1)
    assert set(points.coranks) == {1, 2}
    assert_array_equal(points.exact, points.coranks == 1)


@pytest.mark.parametrize("length_scale", [0.01, 0.5, 30.0])
@pytest.mark.parametrize("name, corank", [("pa10", 2), ("ur5", 1)])
def test_coranks_do_not_depend_on_the_unit_of_length(name, corank, length_scale):
    points = found(name, corank)
    other = chain(name, length_scale=length_scale)
    s = np.linalg.svd(other.jacobian(points.values), compute_uv=False)
    assert_array_equal(coranks(s, s[:, 0]), points.coranks)
    again = project(other, corank, points.values)
    assert again.converged.all()
    assert_allclose(again.values[~points.folded], points.values[~points.folded], atol=1e-6)


@pytest.mark.parametrize("reference", ["local", "world", "local_world_aligned"])
@pytest.mark.parametrize("name, corank", [("pa10", 2), ("ur5", 3), ("tiago", 1)])
def test_coranks_do_not_depend_on_the_reference(name, corank, reference):
    points, robot = found(name, corank), rik.load(name)
    J = robot.jacobian(robot.configuration(points.values), reference=reference)
    s = np.linalg.svd(J, compute_uv=False)
    assert_array_equal(coranks(s, s[:, 0]), points.coranks)


def test_a_planar_arm_is_singular_where_it_is_stretched_or_folded():
    values = found("planar_2r", 1).values
    assert_allclose(np.sin(values[:, 1]), 0, atol=1e-9)
    values = found("planar_3r", 1).values
    assert_allclose(np.sin(values[:, 1:]), 0, atol=1e-9)


def test_the_position_of_a_six_joint_arm_has_singularities_of_its_own(rng):
    robot = rik.load("ur5").with_rows(("x", "y", "z"))
    points = find_points(ScrewChain.of(robot), 1, 200, rng)
    s = np.linalg.svd(robot.jacobian(robot.configuration(points.values)), compute_uv=False)
    assert points.success > 0.9
    assert s[:, 2].max() < 1e-10
    assert s[:, 1].min() > 1e-5


def test_dulebas_arm_loses_rank_two_at_one_known_place_only():
    values = found("duleba_3r", 2).values
    assert_allclose(np.sin(values[:, 2]), 0, atol=1e-9)


# ------------------------------------------------------------------------------------------ the search as such
def test_the_same_seed_gives_the_same_points_and_another_one_others():
    first, same, other = (
        find_points(chain("panda"), 2, 60, np.random.default_rng(seed), progress=None) for seed in (5, 5, 6)
    )
    for name in ("values", "residual", "iterations", "coranks", "dimensions", "folded", "minima", "floors"):
        assert_array_equal(getattr(first, name), getattr(same, name))
    assert first.values.shape != other.values.shape or np.abs(first.values - other.values).max() > 0.1
    assert_array_equal(
        find_points(chain("ur5"), 1, 20).values, find_points(chain("ur5"), 1, 20, np.random.default_rng(0)).values
    )


def test_progress_is_told_and_chunks_change_no_point(monkeypatch):
    starts, told = chain("ur5").random(np.random.default_rng(0), 50), []
    whole = find_points(chain("ur5"), 1, starts)
    monkeypatch.setattr("robust_ik.singularities.find.find_points.CHUNK", 20)
    parts = find_points(chain("ur5"), 1, starts, progress=lambda done, total: told.append((done, total)))
    assert told == [(20, 50), (40, 50), (50, 50)]
    assert_allclose(parts.values, whole.values, atol=1e-9)


def test_starts_that_are_given_are_used_and_not_written_to():
    starts = chain("ur5").random(np.random.default_rng(0), 10)
    before = starts.copy()
    points = find_points(chain("ur5"), 1, starts)
    assert_array_equal(starts, before)
    assert np.median(np.abs(np.sin((points.values - starts) / 2))) < 0.2


def test_what_is_found_cannot_be_written_to():
    with pytest.raises(ValueError, match="read-only"):
        found("ur5", 1).values[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        chain("ur5").tip[0] = 0


def test_convergence_is_quadratic_at_the_end():
    its = chain("pa10")
    values = its.random(np.random.default_rng(2), 200)
    tight, loose = (project(its, 2, values, tolerance) for tolerance in (1e-11, 1e-4))
    assert np.median(tight.tries - loose.tries) <= 2


def test_points_of_parts_are_joined_in_order():
    a, b = found("ur5", 1, 30), found("ur5", 1, 40)
    both = Points.joined([a, b])
    assert len(both) == len(a) + len(b)
    assert_array_equal(both.values[len(a) :], b.values)


# ------------------------------------------------------------------------------------------ the paper's method
def test_the_gradient_method_finds_corank_one_and_fewer_points_of_higher_corank():
    success = []
    for corank in (1, 2, 3):
        points = find_points(chain("pa10"), corank, 40, np.random.default_rng(1), method="gradient")
        robot = rik.load("pa10")
        s = np.linalg.svd(robot.jacobian(points.values), compute_uv=False)
        assert len(points) > 0
        assert s[:, 6 - corank].max() < 1e-10
        success.append(points.success)
    assert success[0] >= 0.95
    assert success[2] < success[1] < success[0]


def test_rotating_a_cluster_keeps_the_sum_of_its_gradients_and_brings_them_together(rng):
    def angles(gradients):
        unit = gradients / np.linalg.norm(gradients, axis=-1, keepdims=True)
        return np.arccos(np.clip(unit @ np.swapaxes(unit, -1, -2), -1, 1)).sum(axis=(-2, -1))

    for size in (2, 3):
        block = rng.normal(size=(20, size, size, 7))
        plain = np.einsum("naak->nak", block)
        rotated = rotated_gradients(block)
        assert_allclose(rotated.sum(axis=1), plain.sum(axis=1), atol=1e-12)
        assert (angles(rotated) <= angles(plain) + 1e-9).all()


# ------------------------------------------------------------------------------------------ refusals
def test_of_fewer_joints_than_rows_the_corank_is_what_is_missing_of_their_number():
    its = ScrewChain.of(rik.load("planar_2r").with_rows(("x", "y", "z")))
    found = find_points(its, 1, 50)
    assert len(found) == 50
    assert np.abs(np.sin(found.values[:, 1])).max() < 1e-9
    with pytest.raises(rik.InputError, match="corank must be 1 to 2, the number of joints, got 3"):
        find_points(its, 3, 10)


@pytest.mark.parametrize("corank", [0, 7, -1, True, 1.0, "1", None])
def test_coranks_that_cannot_be_are_refused(corank):
    with pytest.raises(rik.InputError, match="corank must be 1 to 6"):
        find_points(chain("ur5"), corank, 10)


@pytest.mark.parametrize(
    "options, message",
    [
        ({"starts": 0}, "starts must be at least 1"),
        ({"starts": np.zeros((3, 5))}, r"starts must have shape \(..., any, 6\)"),
        ({"starts": np.zeros((0, 6))}, "starts must be a count or have shape"),
        ({"starts": np.full((1, 6), np.nan)}, "starts must be finite"),
        ({"starts": 10, "tolerance": 0}, "tolerance must be > 0"),
        ({"starts": 10, "method": "magic"}, "method must be 'projection' or 'gradient', got 'magic'"),
    ],
)
def test_arguments_that_cannot_be_meant_are_refused(options, message):
    with pytest.raises(rik.InputError, match=message):
        find_points(chain("ur5"), 1, **options)


def test_chains_refuse_rows_and_lengths_that_cannot_be():
    with pytest.raises(rik.InputError, match="rows must be some of"):
        ScrewChain.of(rik.load("ur5"), rows=("q",))
    with pytest.raises(rik.InputError, match="length_scale must be > 0"):
        ScrewChain.of(rik.load("ur5"), length_scale=0)
