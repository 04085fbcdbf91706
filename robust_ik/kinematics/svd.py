"""The singular value decomposition and what follows from it: measures and projectors.

Everything is batched over leading axes. Up to 16×16 a compiled kernel decomposes (`kernels.matrices.small_svd`), above
that LAPACK. Compiled steps and searches decompose by themselves (`kernels.step`, `kernels.search`); all other code
calls this module, except where a robot is loaded, before anything is compiled (`robot.default_rest`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.checks import Array, as_array
from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError

RANK_TOLERANCE = 1e-12
"""A singular value of at most this fraction of σ₁ counts as zero: the one definition of rank.

Entries of J carry rounding of some 1e-15 of the largest one. What higher levels leave of a lower level's J carries
that times the condition of the levels above. A σ below this limit cannot be told from zero, and its vectors are
arbitrary. One definition for all ensures that no part of a step takes for null space what another one inverts. What is
left of J beside other tasks is measured against σ₁ of the whole J. Filters get every σ as it is: φ fades to 0 there,
or its card says where it jumps.
"""

SMALLEST_SIGMA = 1e-290
"""Singular values below this are taken as zero, so that 1/σ cannot overflow."""


SQUARED = (1e-140, 1e140)
"""Numbers between these have squares, and sums of many squares, that neither vanish nor overflow."""


DEPENDENT = 1e-6
"""A unit row counts as dependent on the rows before if its part orthogonal to them is shorter than this.

This is no definition of rank, but a limit on motion: to hold both rows at their values could take a motion of
1/DEPENDENT times these values.
"""


LARGEST_COMPILED = 16
"""Matrices with more rows or columns go to LAPACK: the largest kernel is `small_svd.vectors_16`."""


@dataclass(frozen=True, eq=False)
class ThinSVD:
    """J = U diag(s) Vt with k = min(m, n) singular values, in descending order.

    Attributes:
        U: Left singular vectors, (..., m, k): task directions.
        s: Singular values, (..., k).
        Vt: Right singular vectors as rows, (..., k, n): joint directions.
    """

    U: Array
    s: Array
    Vt: Array

    def corank(self, threshold: ArrayLike | None = None) -> NDArray[np.int_]:
        """How many singular values are at most `threshold`; default RANK_TOLERANCE σ₁ (and at least 0).

        Args:
            threshold: Absolute threshold, broadcast against the leading axes.

        Returns:
            Rank deficit relative to k = min(m, n), shape (...).
        """
        limit = RANK_TOLERANCE * self.s[..., :1] if threshold is None else np.asarray(threshold)[..., None]
        return np.asarray(np.sum(self.s <= limit, axis=-1))


def svd(J: ArrayLike) -> ThinSVD:
    """The thin singular value decomposition of J.

    Every σ is as exact as the rows or columns allow, at worst up to rounding of σ₁; one below SMALLEST_SIGMA, or below
    about 1e-290 σ₁, is 0. So σ₁ > 0 if an entry is over SMALLEST_SIGMA, and nothing is ever NaN.

    Args:
        J: Matrix, (..., m, n).

    Raises:
        InputError: J is no matrix, is empty, or holds NaN or infinity.
    """
    if not (type(J) is np.ndarray and J.dtype == float and J.ndim > 1):
        J = as_array(J, "J", (None, None))
    if 0 in J.shape[-2:]:
        raise InputError(f"J must have at least one row and one column, got shape {J.shape}")
    return _decomposed(J, full=False)


def full_svd(J: Array) -> ThinSVD:
    """The decomposition with all n right singular vectors, those of the null space last.

    Args:
        J: Finite matrices, (..., m, n); not checked.

    Returns:
        U (..., m, k), s (..., k) and Vt (..., n, n).
    """
    # If there are more rows than columns, all m left singular vectors would come too.
    return _decomposed(J, full=J.shape[-2] < J.shape[-1])


def whole_svd(J: Array) -> ThinSVD:
    """The decomposition with all left and all right singular vectors, for any shape.

    Args:
        J: Finite matrices, (..., m, n); not checked.

    Returns:
        U (..., m, m), s (..., k) and Vt (..., n, n).
    """
    if J.shape[-2] <= J.shape[-1]:
        return full_svd(J)
    turned = full_svd(np.swapaxes(J, -1, -2))
    return ThinSVD(np.swapaxes(turned.Vt, -1, -2), turned.s, np.swapaxes(turned.U, -1, -2))


def singular_values(J: Array) -> Array:
    """The singular values alone, (..., k), descending, of finite matrices (..., m, n), which are not checked."""
    m, n = J.shape[-2:]
    if not 0 < min(m, n) <= max(m, n) <= LARGEST_COMPILED:
        return np.asarray(np.linalg.svd(J, compute_uv=False))
    s = np.empty((*J.shape[:-2], min(m, n)))
    J = np.ascontiguousarray(J, dtype=float)
    if not _compiled("values", max(m, n) <= 8)(J.reshape(-1, m, n), s.reshape(-1, min(m, n))):
        raise _unfit(J)
    return s


def _decomposed(J: Array, *, full: bool) -> ThinSVD:
    m, n = J.shape[-2:]
    if not 0 < min(m, n) <= max(m, n) <= LARGEST_COMPILED:
        return _of_lapack(J, full=full)
    k, batch, right = min(m, n), J.shape[:-2], n if full else min(m, n)
    U, s, Vt = np.empty((*batch, m, k)), np.empty((*batch, k)), np.empty((*batch, right, n))
    if not (J.flags.c_contiguous and J.dtype == float):
        J = np.ascontiguousarray(J, dtype=float)
    small_svd = _compiled("vectors", max(m, n) <= 8)
    if batch:
        good = small_svd(J.reshape(-1, m, n), U.reshape(-1, m, k), s.reshape(-1, k), Vt.reshape(-1, right, n))
    else:
        good = small_svd(J[None], U[None], s[None], Vt[None])
    if not good:
        raise _unfit(J)
    return ThinSVD(U, s, Vt)


@cache
def _compiled(what: str, small: bool) -> Callable[..., bool]:
    """The kernel for "vectors" or "values" of matrices with at most 8, or else LARGEST_COMPILED, rows and columns."""
    from robust_ik.kernels import matrices

    kernel = getattr(matrices, f"{what}_{8 if small else LARGEST_COMPILED}")
    compiled: Callable[..., bool] = kernel.compiled
    return compiled


def _of_lapack(J: Array, *, full: bool) -> ThinSVD:
    if not np.isfinite(J).all():
        raise _unfit(J)
    found = ThinSVD(*np.linalg.svd(J, full_matrices=full))
    if not np.isfinite(found.s).all():
        raise _unfit(J)
    return ThinSVD(found.U, np.where(found.s < SMALLEST_SIGMA, 0.0, found.s), found.Vt)


def _unfit(J: Array) -> InputError:
    """The error for matrices that have no finite decomposition."""
    try:
        as_array(J, "J", (None, None))
    except InputError as error:
        return error
    return InputError(f"J is too large to decompose: its largest entry is {np.abs(J).max():.3g}")


def manipulability(J: ArrayLike) -> Array:
    """Π σᵢ, shape (...).

    The product of singular values is never NaN, unlike √det(J Jᵀ), which rounding can make imaginary.
    Source: Yoshikawa 1985; for m > n the product runs over the n singular values.
    """
    with np.errstate(over="ignore"):
        return np.asarray(np.prod(svd(J).s, axis=-1))


def condition_number(J: ArrayLike) -> Array:
    """σ₁/σ_k, shape (...); infinite at a singularity and for J = 0. Source: J-PARSE, eq. (14)."""
    s = svd(J).s
    largest, smallest = s[..., 0], s[..., -1]
    infinite = smallest <= RANK_TOLERANCE * largest
    return np.asarray(np.where(infinite, np.inf, largest / np.where(infinite, 1.0, smallest)))


@checked
def lost_directions(J: ArrayLike, threshold: float | None = None) -> Array:
    """The task directions that no joint motion gives: columns of U with σ ≤ threshold, and the complement of all in ℝᵐ.

    Args:
        J: One matrix, (m, n).
        threshold: Absolute threshold on σ; default RANK_TOLERANCE σ₁.

    Returns:
        Orthonormal columns, (m, c) with c = m − rank.
    """
    J = as_array(J, "J", (None, None))
    if J.ndim != 2:
        raise InputError(f"lost_directions takes one matrix, got shape {J.shape}")
    decomposition = svd(J)
    rank = decomposition.s.size - int(decomposition.corank(threshold))
    kept = decomposition.U[:, :rank]
    complement = np.eye(J.shape[0]) - kept @ kept.T
    return svd(complement).U[:, : J.shape[0] - rank]


def null_projector(J: ArrayLike) -> Array:
    """I − V Vᵀ, (..., n, n): projects onto joint motions that move the task neither now nor in a singular direction.

    V holds all k = min(m, n) right singular vectors, those of small σ included. So the rank of the projector, n − k,
    does not change when a singularity is passed. I − J# J with a damped J# would leak (1 − σφ(σ)) of the secondary
    motion into the task. Watch for: at σ = 0 exactly and n > m the vectors of vanishing σ are arbitrary ones of the
    null space, so the projector jumps there; it still moves the task nowhere.
    """
    Vt = svd(J).Vt
    return np.asarray(np.eye(Vt.shape[-1]) - np.swapaxes(Vt, -1, -2) @ Vt)


def length(vector: Array) -> float:
    """‖x‖ of one vector, (n,); see `norms`."""
    return float(norms(vector))


def norms(vectors: Array) -> Array:
    """‖x‖ of vectors, (..., n) → (...), exact also where squares would overflow or vanish."""
    largest = np.abs(vectors).max(axis=-1, initial=0.0)
    usual = (largest == 0) | ((SQUARED[0] < largest) & (largest < SQUARED[1]))
    if usual.all():
        return np.asarray(np.linalg.norm(vectors, axis=-1))
    unit = np.where(usual, 1.0, largest)
    return np.asarray(unit * np.linalg.norm(vectors / unit[..., None], axis=-1))


def complement(rows: Array) -> Array:
    """Orthonormal columns that span the orthogonal complement of orthonormal rows, (r, n) → (n, n − r)."""
    Q, _ = np.linalg.qr(rows.T, mode="complete")
    return np.asarray(Q[:, len(rows) :])


def least_norm_solution(rows: Array, values: Array) -> Array | None:
    """The smallest y with rows y = values, or None if the rows depend on each other.

    Args:
        rows: (r, n), each of about unit length.
        values: (r,) or (r, c) for several at once.
    """
    if len(rows) > rows.shape[1]:
        return None
    Q, R = np.linalg.qr(rows.T)
    if len(rows) and np.abs(np.diagonal(R)).min() < DEPENDENT:
        return None
    return np.asarray(Q @ np.linalg.solve(R.T, values))
