"""The compiled decomposition: every σ to its last bits, orthogonal factors, the same bits in every batch."""

import mpmath as mp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from robust_ik.kinematics import svd

SHAPES = [(m, n) for m in (1, 2, 3, 5, 6, 8, 9, 13, 16) for n in (1, 2, 3, 4, 6, 7, 8, 11, 16)]
DIGITS = 60


def orthogonal(n, rng):
    return np.linalg.qr(rng.standard_normal((n, n)))[0]


def well_conditioned(rng, m=6, n=7):
    """Singular values from .3 to 1."""
    return (orthogonal(m, rng) * rng.uniform(0.3, 1, m)) @ orthogonal(n, rng)[:m]


def scales(rng, most, shape):
    return 10.0 ** rng.uniform(-most, most, shape)


MATRICES = {
    "well conditioned": well_conditioned,
    "rows scaled": lambda rng: scales(rng, 12, (6, 1)) * well_conditioned(rng),
    "columns scaled": lambda rng: well_conditioned(rng) * scales(rng, 12, (1, 7)),
    "tall, rows scaled": lambda rng: scales(rng, 12, (7, 1)) * well_conditioned(rng).T,
    "tall, columns scaled": lambda rng: well_conditioned(rng).T * scales(rng, 12, (1, 6)),
    "graded": lambda rng: np.geomspace(1, 1e-15, 6)[:, None] * well_conditioned(rng),
    "graded both ways": lambda rng: well_conditioned(rng) * 10.0 ** -(np.arange(6)[:, None] + np.arange(7)),
    "repeated": lambda rng: orthogonal(6, rng) @ (np.array([1, 1, 1, 0.5, 0.5, 0.5])[:, None] * orthogonal(7, rng)[:6]),
    "times 1e150": lambda rng: 1e150 * well_conditioned(rng),
    "times 1e-150": lambda rng: 1e-150 * well_conditioned(rng),
    "of 16": lambda rng: scales(rng, 12, (11, 1)) * well_conditioned(rng, 11, 16),
}


def exact(A):
    """σ with 60 digits, falling."""
    with mp.workdps(DIGITS):
        M = mp.matrix(A.tolist())
        gram = M * M.T if A.shape[0] <= A.shape[1] else M.T * M
        return [mp.sqrt(abs(value)) for value in sorted(mp.eigsy(gram, eigvals_only=True), reverse=True)]


@pytest.mark.parametrize("kind", MATRICES)
def test_every_singular_value_is_right_to_its_last_bits(kind, rng):
    for _ in range(6):
        A = MATRICES[kind](rng)
        for found, want in zip(svd.svd(A).s.tolist(), exact(A)):
            assert abs(mp.mpf(found) - want) <= 1e-14 * want


def deficient(m, n, rng):
    """What has zeros, equal rows, a zero column and rank one among it."""
    J = rng.standard_normal((7, m, n))
    J[1, :, 0] = 0.0
    J[2, -1] = J[2, 0]
    J[3] = 0.0
    J[4] = np.round(rng.standard_normal((m, 1)) @ rng.standard_normal((1, n)), 1)
    J[5, :, 0], J[5, -1] = 0.0, J[5, 0]
    J[6, : m // 2] = 0.0
    return J


@pytest.mark.parametrize("m, n", SHAPES)
def test_factors_are_orthogonal_and_rebuild_whatever_the_rank(m, n, rng):
    k = min(m, n)
    for J in (deficient(m, n, rng), 1e140 * deficient(m, n, rng), 1e-140 * deficient(m, n, rng)):
        size = np.abs(J).max() or 1.0
        for found in (svd.svd(J), svd.full_svd(J)):
            assert_allclose(np.swapaxes(found.U, -1, -2) @ found.U, np.broadcast_to(np.eye(k), (7, k, k)), atol=1e-13)
            right = found.Vt @ np.swapaxes(found.Vt, -1, -2)
            assert_allclose(right, np.broadcast_to(np.eye(right.shape[-1]), right.shape), atol=1e-13)
            assert_allclose((found.U * (found.s / size)[:, None]) @ found.Vt[:, :k], J / size, atol=1e-13)
            assert (np.diff(found.s, axis=-1) <= 0).all()
            assert_allclose(found.s / size, np.linalg.svd(J / size, compute_uv=False), atol=1e-13)


@pytest.mark.parametrize("m, n", [(3, 3), (6, 7), (7, 6), (6, 6), (2, 9), (12, 5)])
def test_a_matrix_gets_the_same_bits_in_every_batch(m, n, rng):
    J = rng.standard_normal((37, m, n))
    J[::5] *= scales(rng, 6, (1, n))
    J[3] = 0.0
    J[4, -1] = J[4, 0]
    for decompose in (svd.svd, svd.full_svd):
        whole = decompose(J)
        for index in range(37):
            alone, last, first = decompose(J[index]), decompose(J[: index + 1]), decompose(J[index:])
            for part, place in ((alone, ()), (last, index), (first, 0)):
                assert (part.U[place] == whole.U[index]).all()
                assert (part.s[place] == whole.s[index]).all()
                assert (part.Vt[place] == whole.Vt[index]).all()
        assert (svd.singular_values(J) == whole.s).all()


def test_any_layout_is_taken_and_none_is_written_to(rng):
    J = rng.standard_normal((6, 14))
    expected = svd.svd(J[:, ::2].copy())
    locked = J[:, ::2].copy()
    locked.setflags(write=False)
    for given in (J[:, ::2], np.asfortranarray(J[:, ::2]), locked, np.broadcast_to(J[:, ::2], (4, 6, 7))[2]):
        before = given.copy()
        assert (svd.svd(given).s == expected.s).all()
        assert (given == before).all()


def test_more_rows_or_columns_than_are_compiled_are_left_to_lapack(rng):
    J = rng.standard_normal((3, 6, 20))
    found = svd.full_svd(J)
    assert found.Vt.shape == (3, 20, 20)
    assert_allclose(found.s, np.linalg.svd(J, compute_uv=False), rtol=1e-12)
    assert svd.singular_values(np.empty((0, 6, 7))).shape == (0, 6)
    assert svd.svd(np.empty((0, 6, 7))).U.shape == (0, 6, 6)


def test_left_vectors_are_orthonormal_however_small_rows_become(rng):
    for exponent in range(-160, -100, 3):
        A = rng.standard_normal((11, 4, 6))
        A[:, 2:] *= 10.0**exponent
        found = svd.svd(A)
        assert_allclose(np.swapaxes(found.U, -1, -2) @ found.U, np.broadcast_to(np.eye(4), (11, 4, 4)), atol=1e-13)
    J = rng.standard_normal((60, 8, 2)) @ rng.standard_normal((60, 2, 8))
    J[:20] = np.round(J[:20])
    found = svd.svd(J)
    assert_allclose(np.swapaxes(found.U, -1, -2) @ found.U, np.broadcast_to(np.eye(8), (60, 8, 8)), atol=1e-13)


def test_entries_whose_products_underflow_leave_the_others_as_they_are(rng):
    """One entry of 1, the rest from 1e-300 up: σ are right beside σ₁, and factors orthogonal."""
    for exponent in (-100, -145, -155, -165, -200, -300):
        J = 10.0**exponent * rng.choice([1.0, -1.0, 0.3], (300, 3, 3))
        J[np.arange(300), rng.integers(3, size=300), rng.integers(3, size=300)] = 1.0
        found = svd.svd(J)
        assert_allclose(found.s, np.linalg.svd(J, compute_uv=False), atol=1e-14)
        assert_allclose((found.U * found.s[:, None]) @ found.Vt, J, atol=1e-14)
        for factor in (found.U, found.Vt):
            assert_allclose(factor @ np.swapaxes(factor, -1, -2), np.broadcast_to(np.eye(3), J.shape), atol=1e-12)


def test_a_matrix_that_is_not_zero_has_a_singular_value(rng):
    for size in (1e-280, 1e-150, 1.0, 1e150):
        J = size * rng.choice([0.0, 1.0, 1e-8, -1e-120, 1e-155, 1e-290], (400, 4, 6))
        J[:, 0, 0] = size
        assert (svd.svd(J).s[:, 0] >= 0.99 * size).all()
