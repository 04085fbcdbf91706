"""The singular value decomposition and what follows from it: measures and projectors.

This is the only place that calls an SVD. Everything is batched over leading axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.checks import Array, as_array
from robust_ik.errors import InputError

RANK_TOLERANCE = 64 * float(np.finfo(float).eps)
"""A singular value below this fraction of the largest one counts as zero, unless a threshold is given."""


SMALLEST_SIGMA = 1e-290
"""Singular values below this are taken as zero, so that 1/σ cannot overflow."""


DEPENDENT = 1e-6
"""Unit rows whose part that is new to the rows before is shorter than this count as dependent on them."""


LARGEST_COMPILED = 16
"""Matrices with more rows or columns are left to LAPACK."""


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

    Args:
        J: Matrix, (..., m, n).

    Raises:
        InputError: J is no matrix, is empty, or holds NaN or infinity.
    """
    J = as_array(J, "J", (None, None))
    if 0 in J.shape[-2:]:
        raise InputError(f"J must have at least one row and one column, got shape {J.shape}")
    return _decomposed(J, full=False)


def full_svd(J: Array) -> ThinSVD:
    """The decomposition with all n right singular vectors: those of the null space come last.

    Args:
        J: Finite matrices, (..., m, n), from our own hands.

    Returns:
        U (..., m, k), s (..., k) and Vt (..., n, n).
    """
    # Of more rows than columns, all m left singular vectors would come too.
    return _decomposed(J, full=J.shape[-2] < J.shape[-1])


def singular_values(J: Array) -> Array:
    """The singular values alone, (..., k), descending, of finite matrices (..., m, n) from our own hands."""
    m, n = J.shape[-2:]
    if not 0 < max(m, n) <= LARGEST_COMPILED or min(m, n) == 0:
        return np.asarray(np.linalg.svd(J, compute_uv=False))
    from robust_ik.kernels.decompose import values_8, values_16  # imports Numba, half a second: only where it is needed

    s = np.empty((*J.shape[:-2], min(m, n)))
    kernel = values_8 if max(m, n) <= 8 else values_16
    kernel(np.ascontiguousarray(J, dtype=float).reshape(-1, m, n), s.reshape(-1, min(m, n)))
    return s


def _decomposed(J: Array, *, full: bool) -> ThinSVD:
    m, n = J.shape[-2:]
    if not 0 < max(m, n) <= LARGEST_COMPILED or min(m, n) == 0:
        return _checked(J, ThinSVD(*np.linalg.svd(J, full_matrices=full)))
    from robust_ik.kernels.decompose import vectors_8, vectors_16  # imports Numba, as above

    k, batch = min(m, n), J.shape[:-2]
    U, s, Vt = np.empty((*batch, m, k)), np.empty((*batch, k)), np.empty((*batch, n if full else k, n))
    kernel = vectors_8 if max(m, n) <= 8 else vectors_16
    J = np.ascontiguousarray(J, dtype=float)
    kernel(J.reshape(-1, m, n), U.reshape(-1, m, k), s.reshape(-1, k), Vt.reshape(-1, *Vt.shape[-2:]))
    return _checked(J, ThinSVD(U, s, Vt))


def _checked(J: Array, found: ThinSVD) -> ThinSVD:
    if not np.isfinite(found.s).all():
        raise InputError(f"J is too large to decompose: its largest entry is {np.abs(J).max():.3g}")
    if found.s.size and found.s.min() >= SMALLEST_SIGMA:
        return found
    return ThinSVD(found.U, np.where(found.s < SMALLEST_SIGMA, 0.0, found.s), found.Vt)


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


def lost_directions(J: ArrayLike, threshold: float | None = None) -> Array:
    """The task directions that no joint motion can give: columns of U with σ ≤ threshold, and the rest of ℝᵐ.

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
    """I − V Vᵀ, the joint motions that move the task nowhere now *and* in no singular direction, (..., n, n).

    V holds all k = min(m, n) right singular vectors, those of small σ included, so that the rank of the projector,
    n − k, does not change where a singularity is passed. I − J# J with a damped J# would leak (1 − σφ(σ)) of the
    secondary motion into the task. Watch for: at σ = 0 exactly and n > m the vectors of vanishing σ are any of the
    null space, so the projector jumps there; it still moves the task nowhere.
    """
    Vt = svd(J).Vt
    return np.asarray(np.eye(Vt.shape[-1]) - np.swapaxes(Vt, -1, -2) @ Vt)


def complement(rows: Array) -> Array:
    """Orthonormal columns that span what is orthogonal to orthonormal rows, (r, n) → (n, n − r)."""
    Q, _ = np.linalg.qr(rows.T, mode="complete")
    return np.asarray(Q[:, len(rows) :])


def least_norm_solution(rows: Array, values: Array) -> Array | None:
    """The smallest y with rows y = values, or None where the rows depend on each other.

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
