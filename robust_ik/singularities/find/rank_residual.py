"""The residual r = vec(U₂ᵀ J V₂), which vanishes if the corank is at least k, and its derivative. Arrays only.

The corank is g − rank, g being the rank at nearly all configurations: the number of rows or joints, whichever is less,
but for what the arm can never do. U₂ holds the m − g + k weakest left singular vectors, V₂ the n − g + k weakest right
ones. Both are fixed within a step, so that no singular vector is differentiated and clusters need no special treatment.
Where g < min(m, n), some entries of r are always zero, and on a stratum so are their derivatives: they add nothing to
the rank of ∂r/∂q.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import singular_values, whole_svd
from robust_ik.singularities.find.compiled_search import AT_ONCE, compiled_search
from robust_ik.singularities.geometry.screw_chain import ScrewChain

Indices = NDArray[np.int_]
Mask = NDArray[np.bool_]

CLEAR, NOISE = 1e-3, 1e-7
"""Singular values of ∂r/∂q between these fractions of the largest one may or may not be zero: at a residual of 1e-11
that vanishes to second order they are about 1e-6.
"""
FLAT = 1e-4
"""∂r/∂q below this fraction of σ₁ may be zero."""
SAME_CORANK = 1e-6
"""Singular values below this fraction of σ₁ count as zero at a polished point."""


@dataclass(frozen=True, eq=False)
class Residual:
    """The residual of N configurations.

    Attributes:
        corank: k.
        s: Singular values of the Jacobian, (N, min(m, n)).
        derivative: ∂r/∂q, (N, (m − g + k) (n − g + k), n): of U₂ᵀ J V₂ row by row, or of its transpose if m > n.
        scale: The scale of singular values, (N,): σ₁, unless the whole Jacobian vanishes.
        full: g, the rank where the arm is not singular.
    """

    corank: int
    s: Array
    derivative: Array
    scale: Array
    full: int

    @classmethod
    def at(cls, chain: ScrewChain, values: Array, corank: int) -> Residual:
        """The residual at joint values (N, n)."""
        found = compiled_search(chain, corank, values, AT_ONCE)
        if found is None:
            return cls.by_numpy(chain, values, corank)
        return cls(corank, found.s, found.derivative, found.scale, chain.full_rank)

    @classmethod
    def by_numpy(cls, chain: ScrewChain, values: Array, corank: int) -> Residual:
        """The same, step by step: the reference of compiled code, and for any number of joints."""
        found, kept = whole_svd(chain.jacobian(values)), chain.full_rank - corank
        left = found.U[..., kept:]
        right = np.swapaxes(found.Vt[..., kept:, :], -1, -2)
        A = chain.contraction(values, left, right)
        if chain.m > chain.n:
            A = np.ascontiguousarray(np.swapaxes(A, 1, 2))
        A = A.reshape(len(values), left.shape[-1] * right.shape[-1], chain.n)
        scale = np.maximum(found.s[:, 0], chain.least_scale)
        return cls(corank, found.s, A, scale, chain.full_rank)

    @property
    def weakest(self) -> Array:
        """The diagonal of r, zero elsewhere: all singular values but the g − k largest, k if none is always zero."""
        return np.asarray(self.s[:, self.full - self.corank :])

    @property
    def coranks(self) -> Indices:
        """The corank at each of polished points, (N,)."""
        return coranks(self.s[:, : self.full], self.scale)

    @property
    def norm(self) -> Array:
        """‖r‖, (N,)."""
        return np.asarray(np.sqrt(np.sum(self.weakest**2, axis=-1)))

    @property
    def relative(self) -> Array:
        """‖r‖/σ₁, (N,); 0 for a Jacobian that is zero."""
        return self.of_scale(self.norm)

    def of_scale(self, norm: Array) -> Array:
        """Norms as fractions of σ₁, (N,)."""
        return np.asarray(norm / np.where(self.scale > 0, self.scale, 1.0))

    @property
    def vector(self) -> Array:
        """The residual r as vectors, (N, (m − g + k) (n − g + k))."""
        k, rows = self.weakest.shape[1], self.derivative.shape[1]
        r = np.zeros((len(self.weakest), rows))
        r[:, np.arange(k) * (rows // k + 1)] = self.weakest
        return r

    def select(self, which: Indices) -> Residual:
        """The residual of some of the configurations."""
        return Residual(self.corank, self.s[which], self.derivative[which], self.scale[which], self.full)

    def put(self, which: Indices, other: Residual) -> None:
        """Replaces the residuals of some configurations."""
        self.s[which], self.derivative[which], self.scale[which] = other.s, other.derivative, other.scale


def check_corank(chain: ScrewChain, corank: int) -> None:
    """Raises if a chain cannot have this corank.

    Raises:
        InputError: The message says what is possible.
    """
    most = chain.full_rank
    if isinstance(corank, bool) or not isinstance(corank, (int, np.integer)) or not 1 <= corank <= most:
        what = "the number of task rows" if chain.m <= chain.n else "the number of joints"
        if most < min(chain.m, chain.n):
            what = "the rank that the arm has at most"
        raise InputError(f"corank must be 1 to {most}, {what}, got {corank!r}")


def coranks(s: Array, scale: Array | float) -> Indices:
    """How many singular values of polished points are zero relative to a scale, (..., g) → (...)."""
    return np.asarray(np.sum(s <= SAME_CORANK * np.asarray(scale)[..., None], axis=-1))


def ranks(derivative: Array, sigma: Array | float = 0.0) -> tuple[Indices, Mask]:
    """The rank of each matrix and whether it is clear.

    Args:
        derivative: ∂r/∂q, (N, p, n).
        sigma: σ₁ of the Jacobians, (N,): if ∂r/∂q is small as a whole relative to it, the rank is not clear.

    Returns:
        How many singular values are not zero, (N,), and whether none is doubtful, (N,).
    """
    a = singular_values(derivative)
    largest = a[:, :1]
    kept, doubtful = a > CLEAR * largest, (a > NOISE * largest) & (a <= CLEAR * largest)
    clear = ~doubtful.any(axis=1) & (largest[:, 0] >= FLAT * np.asarray(sigma))
    return np.asarray(np.sum(kept, axis=1)), np.asarray(clear)
