"""Eigenvectors and factors of small symmetric matrices in compiled code."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from robust_ik.kernels.compiler.compiling import FLOAT, filled, given, kernel
from robust_ik.kernels.compiler.stack_memory import pointer
from robust_ik.kernels.loader.kernel import Kernel
from robust_ik.kernels.matrices.definite_systems import factor_definite, solve_factored
from robust_ik.kernels.matrices.symmetric_eigenvectors import diagonalise


@kernel(filled(2), filled(1), filled(2))
def eigen(A, values, vectors):
    diagonalise(pointer(A), len(A), pointer(values), pointer(vectors))


@kernel(given(2), FLOAT, filled(2), filled(1))
def shifted(A, shift, L, x):
    good = factor_definite(pointer(A), len(A), shift, pointer(L))
    if good:
        solve_factored(pointer(L), len(A), pointer(x))
    return good


def symmetric(rng, size, kind):
    A = rng.normal(size=(size, size))
    A = A + A.T
    if kind == "repeated":
        Q = np.linalg.qr(A)[0]
        A = (Q * np.sign(np.arange(size) - size // 2)) @ Q.T
        A = 0.5 * (A + A.T)
    return {"zero": 0 * A, "diagonal": np.diag(np.diag(A)), "large": 1e200 * A, "small": 1e-200 * A}.get(kind, A)


@pytest.mark.parametrize("kind", ["random", "repeated", "zero", "diagonal", "large", "small"])
def test_eigenvectors_are_orthonormal_and_give_the_matrix(kind, rng):
    run = Kernel(__name__, "eigen").compiled
    for size in (1, 2, 3, 5, 8, 16):
        A = symmetric(rng, size, kind)
        values, vectors = np.empty(size), np.empty((size, size))
        run(A.copy(), values, vectors)
        scale = np.abs(A).max()
        assert_allclose(vectors @ vectors.T, np.eye(size), atol=1e-14)
        assert_allclose((vectors.T * values) @ vectors, A, rtol=0, atol=3e-15 * size * scale)
        assert_allclose(np.sort(values), np.linalg.eigvalsh(A), rtol=0, atol=3e-15 * size * scale)


def test_a_matrix_is_factored_if_and_only_if_it_is_positive_definite(rng):
    run = Kernel(__name__, "shifted").compiled
    for size in (1, 2, 5, 16):
        A, b = symmetric(rng, size, "random"), rng.normal(size=size)
        least = np.linalg.eigvalsh(A)[0]
        x = b.copy()
        assert run(A, 0.1 - least, np.empty((size, size)), x)
        assert_allclose((A + (0.1 - least) * np.eye(size)) @ x, b, atol=1e-11)
        assert not run(A, -0.1 - least, np.empty((size, size)), b.copy())
    assert not run(np.zeros((2, 2)), 0.0, np.empty((2, 2)), np.ones(2))
