"""Determinants that show why adding to M = J Jᵀ always cures a singularity, and adding to J does not. Arrays only."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array
from robust_ik.checks.public_arguments import computed
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import svd


@computed
def determinant_excess(A: ArrayLike, M: ArrayLike) -> Array:
    """det(A + M) − det A − det M, never negative for A > 0 and M ≥ 0, shape (...).

    It is det A · R with R = e₁ + … + e_{m−1}, the elementary symmetric polynomials of the eigenvalues of A⁻¹M, and is
    summed in that form, without cancellation. So it is positive for M ≠ 0 *and m ≥ 2*; the paper leaves the second
    condition out: for m = 1 there is no excess. Likewise det(A + M) − det A = det A · R, eq. (16), needs det M = 0.

    Args:
        A: Symmetric, positive definite, (..., m, m).
        M: Symmetric, positive semidefinite, (..., m, m).

    Raises:
        InputError: A or M does not have these properties.

    Source: Duleba 2023, eqs. (7) to (10).
    """
    A, M = _symmetric(A, "A"), _symmetric(M, "M")
    if A.shape[-1] != M.shape[-1]:
        raise InputError(f"A and M must have the same size, got {A.shape} and {M.shape}")
    try:
        root = np.linalg.cholesky(A)
    except np.linalg.LinAlgError as error:
        raise InputError("A must be positive definite") from error
    half = np.linalg.solve(root, M)
    whole = np.linalg.solve(root, np.swapaxes(half, -1, -2))
    eigenvalues = np.linalg.eigvalsh((whole + np.swapaxes(whole, -1, -2)) / 2)
    if (eigenvalues < -1e-9 * np.abs(eigenvalues).max(axis=-1, keepdims=True)).any():
        raise InputError("M must be positive semidefinite")
    symmetric = _elementary_symmetric(np.maximum(eigenvalues, 0.0))
    determinant = np.prod(np.diagonal(root, axis1=-2, axis2=-1), axis=-1) ** 2
    return np.asarray(determinant * symmetric[..., 1:-1].sum(axis=-1))


def _elementary_symmetric(values: Array) -> Array:
    """e₀, e₁, …, e_m of (..., m) values: the coefficients of Π(1 + t vᵢ)."""
    m = values.shape[-1]
    e = np.zeros((*values.shape[:-1], m + 1))
    e[..., 0] = 1
    for i in range(m):
        e[..., 1:] += e[..., :-1] * values[..., i : i + 1]
    return e


@computed
def allows_multiplicative_inverse(m: int, n: int, corank: int) -> bool:
    """Whether some Ψ of rank m has J Ψᵀ = 0, so that (J + Ψ)(J + Ψ)ᵀ = J Jᵀ + ΨΨᵀ is regular: n − m + c ≥ m.

    It rarely holds, for example not for n = 4, m = 3, c = 1; so there is no such inverse here.

    Args:
        m: Task rows.
        n: Joints.
        corank: c = m − rank J, at least m − n.

    Source: Duleba 2023, eqs. (17) to (19).
    """
    if not (m >= 1 and n >= 1 and max(m - n, 0) <= corank <= m):
        raise InputError(f"m, n ≥ 1 and max(m − n, 0) ≤ corank ≤ m must hold, got m={m}, n={n}, corank={corank}")
    return n - m + corank >= m


@computed
def fatal_dampings(J: ArrayLike) -> Array:
    """The real λ ≠ 0 for which J + λI is singular, ascending: why J itself must not be damped.

    They are minus the real eigenvalues of J. At a singular 2 × 2 Jacobian det(J + λI) = λ(tr J + λ), so λ = −tr J is
    one; M = J Jᵀ has no positive one, whatever J is.

    Args:
        J: One square matrix, (n, n).

    Source: Duleba 2023, eqs. (42) to (44).
    """
    J = as_array(J, "J", (None, None))
    if J.ndim != 2 or J.shape[0] != J.shape[1]:
        raise InputError(f"fatal_dampings takes one square matrix, got shape {J.shape}")
    eigenvalues = np.linalg.eigvals(J)
    # A multiple eigenvalue is only accurate to the root of the precision.
    rounding = np.sqrt(np.finfo(float).eps) * float(svd(J).s[0])
    real = np.abs(eigenvalues.imag) <= rounding
    return np.sort(-eigenvalues.real[real & (np.abs(eigenvalues) > rounding)])


def _symmetric(value: ArrayLike, name: str) -> Array:
    array = as_array(value, name, (None, None))
    if 0 in array.shape[-2:] or array.shape[-1] != array.shape[-2]:
        raise InputError(f"{name} must be square, got shape {array.shape}")
    difference = np.abs(array - np.swapaxes(array, -1, -2)).max(axis=(-2, -1))
    if (difference > 1e-9 * np.abs(array).max(axis=(-2, -1))).any():
        raise InputError(f"{name} must be symmetric, got {np.array2string(array, threshold=8, precision=4)}")
    return array
