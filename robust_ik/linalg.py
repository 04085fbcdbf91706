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
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    if not np.isfinite(s).all():
        raise InputError(f"J is too large to decompose: its largest entry is {np.abs(J).max():.3g}")
    return ThinSVD(U, np.where(s < SMALLEST_SIGMA, 0.0, s), Vt)


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
