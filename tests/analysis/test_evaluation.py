"""Dułęba's evaluation: how much a cure changes, how far from the singularity it gets, and what must not be damped."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose

from robust_ik import InputError, svd
from robust_ik.analysis import evaluation
from robust_ik.inverses import DampedLeastSquares, MoorePenrose
from tests.kinematics.test_svd import SHAPES, matrix

FLOOR = 0.1


def spectra(rng, k, below, count):
    """Descending spectra with exactly `below` of k values under FLOOR."""
    s = np.concatenate([rng.uniform(FLOOR, 2, (count, k - below)), rng.uniform(0, FLOOR, (count, below))], axis=-1)
    return -np.sort(-s, axis=-1)


def modified(J, change):
    """J Jᵀ or JᵀJ, the smaller one, with σ² replaced by change(σ)²."""
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    basis = U if U.shape[0] <= Vt.shape[1] else Vt.T
    return basis @ np.diag(change(s) ** 2) @ basis.T


@pytest.mark.parametrize("m, n", SHAPES)
def test_the_modifications_are_trace_increases_and_the_safeties_smallest_eigenvalues(m, n, rng):
    k, squared = min(m, n), 0.03
    J = matrix(np.sort(rng.uniform(0, 0.3, k))[::-1], m, n, rng)
    s = svd(J).s
    M = J @ J.T if m <= n else J.T @ J
    damped, clamped = M + squared * np.eye(k), modified(J, lambda s: np.maximum(s, FLOOR))
    assert_allclose(evaluation.modification_by_damping(s, squared), np.trace(damped - M), atol=1e-12)
    assert_allclose(evaluation.modification_by_clamp(s, FLOOR), np.trace(clamped - M), atol=1e-12)
    assert_allclose(evaluation.safety_by_damping(s, squared), np.linalg.eigvalsh(damped)[0], atol=1e-12)
    assert_allclose(evaluation.safety_by_clamp(s, FLOOR), np.linalg.eigvalsh(clamped)[0], atol=1e-12)


def test_the_matching_damping_modifies_as_much_as_the_clamp():
    s = np.array([0.4709, 0.1260, 0.0])
    squared = evaluation.matching_squared_damping(s, 1e-2)
    assert_allclose(squared, 1e-4 / 3)
    assert_allclose(
        evaluation.modification_by_damping(s, squared), evaluation.modification_by_clamp(s, 1e-2), rtol=1e-12
    )
    # λ is the squared damping of damped least squares.
    P = DampedLeastSquares(float(np.sqrt(squared))).matrix(np.diag(s))
    assert_allclose(P, np.diag(s) @ np.linalg.inv(np.diag(s) ** 2 + squared * np.eye(3)), atol=1e-12)


def test_the_matched_inverse_is_damped_least_squares_with_the_matching_damping(rng):
    inverse = evaluation.DulebaMatched(FLOOR)
    for m, n in SHAPES:
        J = matrix(np.sort(10 ** rng.uniform(-4, 0, min(m, n)))[::-1], m, n, rng)
        squared = float(evaluation.matching_squared_damping(svd(J).s, FLOOR))
        expected = np.linalg.solve(J.T @ J + squared * np.eye(n), J.T) if squared else np.linalg.pinv(J)
        assert_allclose(inverse.matrix(J), expected, atol=1e-6)
        xdot = rng.normal(size=m)
        assert_allclose(inverse.solve(J, xdot), expected @ xdot, atol=1e-5)


def test_the_matched_inverse_is_exact_above_the_floor_and_nowhere_else():
    inverse = evaluation.DulebaMatched(FLOOR)
    assert_allclose(inverse.gains([2.0, FLOOR]), [1 / 2, 1 / FLOOR], rtol=1e-12)
    assert inverse.is_exact([2.0, FLOOR]).all()
    assert not inverse.is_exact([2.0, 0.99 * FLOOR]).any()
    assert inverse.gains([2.0, 0.99 * FLOOR])[0] < 1 / 2
    assert not inverse.gains(np.zeros(3)).any()
    assert inverse.continuous


@pytest.mark.parametrize("k", range(1, 9))
def test_the_largest_gain_of_the_matched_inverse_grows_with_the_number_of_rows(k, rng):
    inverse = evaluation.DulebaMatched(FLOOR)
    at_peak = np.append(np.full(k - 1, 1.0), FLOOR / np.sqrt(max(k - 1, 1)))
    assert_allclose(inverse.gains(at_peak)[-1], inverse.peak(k), rtol=1e-9)
    s = -np.sort(-(10 ** rng.uniform(-4, 0.5, (20_000, k))))
    assert inverse.gains(s).max() <= inverse.peak(k) * (1 + 1e-9)
    assert inverse.largest_gain(1.0) == np.inf
    assert inverse.largest_gain(0.0) == 0
    with pytest.raises(InputError, match="k must be at least 1"):
        inverse.peak(0)


def test_the_clamp_gets_farther_for_the_same_modification(rng):
    """P21: h₁ < h₂ strictly for 0 < c < k, on 10⁴ random draws."""
    for k, c in itertools.product(range(2, 7), range(1, 6)):
        if c < k:
            both = evaluation.compare_damping_and_clamp(spectra(rng, k, c, 700)[..., None] * np.eye(k), FLOOR)
            assert (both.damped < both.clamped).all()
            assert_allclose(both.clamped, FLOOR**2, rtol=1e-12)
            assert_allclose(k * both.squared_damping, both.modification)


def test_damping_and_clamp_get_equally_far_where_all_singular_values_are_small_and_alike():
    equal = evaluation.compare_damping_and_clamp(0.02 * np.eye(3), FLOOR)
    assert_allclose(equal.damped, equal.clamped, rtol=1e-12)
    unequal = evaluation.compare_damping_and_clamp(np.diag([0.05, 0.02, 0.01]), FLOOR)
    assert unequal.damped < unequal.clamped
    zero = evaluation.compare_damping_and_clamp(np.zeros((2, 3)), FLOOR)
    assert_allclose([zero.damped, zero.clamped], FLOOR**2)


def test_a_healthy_jacobian_is_left_alone():
    """Here the printed h₂ = d_min² would say that the clamp moves it towards the singularity."""
    healthy = evaluation.compare_damping_and_clamp(np.diag([2.0, 1.0]), FLOOR)
    assert healthy.squared_damping == healthy.modification == 0
    assert healthy.damped == healthy.clamped == 1


def test_comparisons_run_over_leading_axes(rng):
    J = rng.normal(size=(2, 3, 4, 6)) * 0.1
    both = evaluation.compare_damping_and_clamp(J, FLOOR)
    one = evaluation.compare_damping_and_clamp(J[1, 2], FLOOR)
    for name in ("squared_damping", "modification", "damped", "clamped"):
        assert getattr(both, name).shape == (2, 3)
        assert_allclose(getattr(both, name)[1, 2], getattr(one, name), rtol=1e-12)


# ------------------------------------------------------------------------------------------------ determinants
@pytest.mark.parametrize("m", [2, 3, 6])
@pytest.mark.parametrize("rank", [0, 1, 2, 6])
def test_the_determinant_of_a_sum_exceeds_the_sum_of_determinants(m, rank, rng):
    """P21: eq. (7), strictly for M ≠ 0 and m ≥ 2, on random draws."""
    root, B = rng.normal(size=(500, m, m)), rng.normal(size=(500, m, min(rank, m)))
    A = root @ np.swapaxes(root, -1, -2) + 0.1 * np.eye(m)
    M = B @ np.swapaxes(B, -1, -2)
    excess = evaluation.determinant_excess(A, M)
    direct = np.linalg.det(A + M) - np.linalg.det(A) - (np.linalg.det(M) if rank >= m else 0)
    assert_allclose(excess, direct, rtol=1e-6, atol=1e-9 * np.linalg.det(A + M).max())
    assert (excess > 0).all() if rank else (excess == 0).all()


def test_a_single_row_has_no_excess_so_the_inequality_needs_two():
    assert evaluation.determinant_excess([[2.0]], [[3.0]]) == 0


def test_the_excess_of_a_tiny_modification_is_not_rounded_away():
    A, M = 1e-12 * np.eye(2), np.diag([1.0, 0.0])
    assert_allclose(evaluation.determinant_excess(A, M), 1e-12, rtol=1e-12)
    assert np.linalg.det(A + M) - np.linalg.det(A) - np.linalg.det(M) > 0
    B = np.diag([1e-20, 1.0])
    assert_allclose(evaluation.determinant_excess(np.eye(2), B @ M @ B), 1e-40, rtol=1e-12)


def test_det_a_plus_m_minus_det_a_is_the_excess_only_where_m_is_singular(rng):
    """Eq. (16) holds at a singularity; elsewhere det M is missing."""
    A, B = np.diag([1.0, 2.0, 0.5]), rng.normal(size=(3, 3))
    for M, singular in [(B[:, :2] @ B[:, :2].T, True), (B @ B.T, False)]:
        printed = np.linalg.det(A + M) - np.linalg.det(A)
        assert np.isclose(printed, evaluation.determinant_excess(A, M), rtol=1e-9) == singular


@pytest.mark.parametrize(
    "A, M, match",
    [
        (np.diag([1.0, 0]), np.eye(2), "A must be positive definite"),
        (np.eye(2), np.diag([1.0, -1]), "M must be positive semidefinite"),
        ([[1.0, 2], [0, 1]], np.eye(2), "A must be symmetric"),
        (np.eye(2), np.eye(3), "same size"),
        (np.eye(2), np.ones((2, 3)), "M must be square"),
        (np.eye(2), [[np.nan, 0], [0, 1]], "M must be finite"),
    ],
)
def test_matrices_that_the_inequality_is_not_about_are_refused(A, M, match):
    with pytest.raises(InputError, match=match):
        evaluation.determinant_excess(A, M)


@pytest.mark.parametrize("m, n", [(1, 1), (1, 3), (2, 2), (2, 4), (3, 4), (3, 7), (4, 2), (6, 7)])
def test_a_multiplicative_inverse_exists_exactly_where_the_null_space_of_j_has_m_dimensions(m, n, rng):
    for c in range(max(m - n, 0), m + 1):
        J = matrix(np.concatenate([np.ones(m - c), np.zeros(min(m, n) - (m - c))]), m, n, rng)
        null_space = n - np.linalg.matrix_rank(J)
        assert evaluation.allows_multiplicative_inverse(m, n, c) == (null_space >= m)
    assert not evaluation.allows_multiplicative_inverse(3, 4, 1)
    with pytest.raises(InputError, match="corank ≤ m"):
        evaluation.allows_multiplicative_inverse(2, 3, 3)
    with pytest.raises(InputError, match="got m=4, n=2, corank=1"):
        evaluation.allows_multiplicative_inverse(4, 2, 1)


def test_damping_a_singular_jacobian_itself_may_make_it_singular_again(rng):
    for _ in range(100):
        a, b = rng.normal(size=(2, 2))
        J = np.outer(a, b)
        fatal = evaluation.fatal_dampings(J)
        assert_allclose(fatal, [-np.trace(J)], rtol=1e-9)
        assert_allclose(np.linalg.det(J + fatal[0] * np.eye(2)), 0, atol=1e-12)
        assert_allclose(np.linalg.det(J + 0.3 * np.eye(2)), 0.3 * (np.trace(J) + 0.3), atol=1e-12)  # (44)
        assert not (evaluation.fatal_dampings(J @ J.T) > 0).any()


def test_fatal_dampings_of_larger_matrices_and_of_none(rng):
    J = rng.normal(size=(5, 5))
    for damping in evaluation.fatal_dampings(J):
        assert np.linalg.svd(J + damping * np.eye(5))[1][-1] < 1e-12
    assert evaluation.fatal_dampings([[0.0, -1], [1, 0]]).size == 0
    assert evaluation.fatal_dampings(np.zeros((3, 3))).size == 0
    assert_allclose(evaluation.fatal_dampings(-2 * np.eye(2)), [2, 2])
    with pytest.raises(InputError, match="one square matrix"):
        evaluation.fatal_dampings(np.ones((2, 3)))


# ------------------------------------------------------------------------------------------------ normalisation
def test_normalised_singular_values_do_not_depend_on_the_unit_of_length(rng):
    J, extents = rng.normal(size=(4, 3, 5)), np.array([0.8, 0.8, 3.0])
    unit = np.array([1000.0, 1000.0, 1.0])  # two rows in mm instead of m
    expected = svd(evaluation.normalise(J, extents)).s
    assert_allclose(svd(evaluation.normalise(unit[:, None] * J, unit * extents)).s, expected, rtol=1e-9)


def test_normalising_leaves_an_exact_solution_alone(rng):
    J, xdot, extents = rng.normal(size=(3, 5)), rng.normal(size=3), np.array([0.8, 2.0, 3.0])
    normal = evaluation.normalise(J, extents)
    assert_allclose(MoorePenrose().solve(normal, xdot / extents), MoorePenrose().solve(J, xdot), atol=1e-12)


@pytest.mark.parametrize("extents, match", [([1.0, 0], "extents must be > 0"), ([1.0], "extents must have shape")])
def test_extents_that_cannot_be_meant_are_refused(extents, match):
    with pytest.raises(InputError, match=match):
        evaluation.normalise(np.eye(2), extents)


@pytest.mark.parametrize(
    "call, match",
    [
        (lambda: evaluation.modification_by_clamp([1.0, 2.0], 0.1), "descending order"),
        (lambda: evaluation.modification_by_clamp([1.0, -0.1], 0.1), "descending order"),
        (lambda: evaluation.modification_by_clamp([], 0.1), "descending order"),
        (lambda: evaluation.modification_by_clamp([1.0], 0.0), "floor must be > 0"),
        (lambda: evaluation.modification_by_damping([1.0], -1.0), "squared_damping must be ≥ 0"),
        (lambda: evaluation.safety_by_clamp([1.0], -1.0), "floor must be > 0"),
        (lambda: evaluation.DulebaMatched(floor=0.0), "floor must be > 0"),
        (lambda: evaluation.safety_by_damping([np.inf], 1.0), "s must be finite"),
    ],
)
def test_what_cannot_be_meant_is_refused(call, match):
    with pytest.raises(InputError, match=match):
        call()
