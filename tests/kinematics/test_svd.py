"""Properties of the decomposition, the measures and the projectors."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.testing import assert_allclose

from robust_ik import InputError, checks
from robust_ik.kinematics import svd

SHAPES = [(1, 1), (1, 5), (2, 2), (3, 3), (3, 7), (6, 6), (6, 7), (6, 2), (4, 1)]


def matrix(s, m, n, rng):
    """A random matrix with singular values s."""
    k = min(m, n)
    U, V = np.linalg.qr(rng.normal(size=(m, k)))[0], np.linalg.qr(rng.normal(size=(n, k)))[0]
    return U @ np.diag(s) @ V.T


@pytest.mark.parametrize("m, n", SHAPES)
def test_svd_rebuilds_the_matrix_over_batches(m, n, rng):
    J = rng.normal(size=(2, 3, m, n))
    d = svd.svd(J)
    assert_allclose((d.U * d.s[..., None, :]) @ d.Vt, J, atol=1e-13)
    assert (np.diff(d.s, axis=-1) <= 0).all()


@pytest.mark.parametrize("m, n", SHAPES)
@pytest.mark.parametrize("zeros", [0, 1, 2])
def test_corank_counts_the_vanishing_singular_values(m, n, zeros, rng):
    k = min(m, n)
    if zeros > k:
        return
    s = np.concatenate([np.linspace(2, 1, k - zeros), np.zeros(zeros)])
    J = matrix(s, m, n, rng)
    assert svd.svd(J).corank() == zeros
    lost = svd.lost_directions(J)
    assert lost.shape == (m, m - k + zeros)
    assert_allclose(lost.T @ J, 0, atol=1e-14)
    assert_allclose(lost.T @ lost, np.eye(m - k + zeros), atol=1e-13)


def test_a_zero_matrix_has_full_corank_and_loses_everything():
    J = np.zeros((3, 4))
    assert svd.svd(J).corank() == 3
    assert svd.lost_directions(J).shape == (3, 3)
    assert svd.manipulability(J) == 0
    assert svd.condition_number(J) == np.inf
    assert_allclose(svd.null_projector(J), svd.null_projector(J).T, atol=1e-15)


@pytest.mark.parametrize("m, n", [(2, 3), (3, 7), (6, 7)])
def test_manipulability_is_the_root_of_the_gram_determinant(m, n, rng):
    J = rng.normal(size=(10, m, n))
    gram = J @ np.swapaxes(J, -1, -2)
    assert_allclose(svd.manipulability(J), np.sqrt(np.linalg.det(gram)), rtol=1e-9)


def test_manipulability_is_no_nan_where_the_determinant_rounds_below_zero(rng):
    J = matrix([1, 1e-9, 1e-12], 3, 3, rng)
    assert svd.manipulability(np.array([J] * 4)).shape == (4,)
    assert (svd.manipulability(J) >= 0).all()


@pytest.mark.parametrize("m, n", SHAPES)
def test_the_null_projector_moves_the_task_nowhere(m, n, rng):
    J = rng.normal(size=(5, m, n))
    N = svd.null_projector(J)
    assert_allclose(J @ N, 0, atol=1e-13)
    assert_allclose(N @ N, N, atol=1e-13)
    assert_allclose(np.trace(N, axis1=-2, axis2=-1), max(n - m, 0), atol=1e-12)


@pytest.mark.parametrize("gap", [1e-3, 1e-9, 0.0])
def test_the_null_projector_excludes_singular_directions_too(gap, rng):
    # Its trace stays n − m at a singularity, so that it is continuous there.
    N = svd.null_projector(matrix([2, 1, gap], 3, 5, rng))
    assert_allclose(np.trace(N), 2, atol=1e-12)


@given(hnp.arrays(float, (3, 4), elements=st.floats(-1e3, 1e3)))
def test_the_condition_number_is_at_least_one(J):
    assert svd.condition_number(J) >= 1


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused(bad):
    with pytest.raises(InputError, match="J must be finite"):
        svd.svd([[1, bad]])


@pytest.mark.parametrize("bad, match", [(3.0, r"shape \(\.\.\., any, any\)"), ([1, 2], r"\(2,\)"),
                                        (np.zeros((0, 3)), "at least one row"), ("abc", "real numbers"),
                                        ([[1, 2], [3]], "real numbers")])  # fmt: skip
def test_what_is_no_matrix_is_refused(bad, match):
    with pytest.raises(InputError, match=match):
        svd.svd(bad)


def test_lost_directions_takes_one_matrix():
    with pytest.raises(InputError, match="one matrix"):
        svd.lost_directions(np.zeros((2, 3, 3)))


def test_readonly_copies_and_locks():
    given_array = np.zeros(3)
    locked = checks.readonly(given_array)
    given_array[0] = 1
    assert locked[0] == 0
    with pytest.raises(ValueError, match="read-only"):
        locked[0] = 1


def test_thresholds_are_absolute(rng):
    J = matrix([1, 0.1, 0.01], 3, 4, rng)
    assert [int(svd.svd(J).corank(t)) for t in (0.001, 0.05, 0.5, 2)] == [0, 1, 2, 3]
    assert svd.lost_directions(J, 0.05).shape == (3, 1)
    assert_allclose(np.linalg.norm(svd.lost_directions(J, 0.05).T @ J), 0.01)


def test_what_overflows_is_refused_or_infinite():
    with pytest.raises(InputError, match="too large to decompose"):
        svd.svd(np.full((3, 3), 1e308))
    assert svd.manipulability(1e100 * np.eye(6)) == np.inf


@pytest.mark.parametrize("size", [0.0, 5e-324, 1e-200, 1e-150, 1.0, 1e150, 1e307])
def test_a_length_is_the_same_share_of_a_vector_whatever_its_size(size):
    vector = size * np.array([3.0, -4.0, 0.0])
    assert_allclose(svd.length(vector), 5 * size, rtol=1e-12)
    assert_allclose(svd.norms(np.stack([vector, vector / 4])), [5 * size, 5 * size / 4], rtol=1e-12, atol=1e-323)


def test_the_length_of_nothing_is_nothing():
    assert svd.length(np.zeros(0)) == 0
