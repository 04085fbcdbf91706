"""Null spaces: the joint motions that higher levels leave free, and a level's Jacobian in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.svd import RANK_TOLERANCE, full_svd, singular_values


@dataclass(frozen=True, eq=False)
class Reduced:
    """J Z Zᵀ = U diag(s) Vt: a level's Jacobian in the freedom left to it, whose basis is Z.

    Attributes:
        U: Task directions, (m, k) with k = min(m, d).
        s: Singular values, (k,), descending; those of rows that higher levels already fix are zero. For the first level
            they are unchanged: with the small σ left at a singularity, a filter moves the arm out of it.
        Vt: Joint directions as rows, (k, n), orthonormal.
        own: All singular values of J itself, descending.
        below: The basis of the motions that the level leaves to lower ones, (n, d').
        idle: The basis of the motions that do not move the level, (n, d − rank), within `below`.
        rank: Number of singular values over RANK_TOLERANCE · σ₁ of J itself.
    """

    U: Array
    s: Array
    Vt: Array
    own: Array
    below: Array
    idle: Array
    rank: int

    @property
    def matrix(self) -> Array:
        """J Z Zᵀ, (m, n)."""
        return (self.U * self.s) @ self.Vt

    @property
    def motions(self) -> Array:
        """The joint directions that move the level, as rows, (rank, n)."""
        return self.Vt[: self.rank]

    @property
    def taken(self) -> Array:
        """The joint directions that lower levels may not use, as rows: `motions` except released or lost ones."""
        return self.Vt[: self.rank - (self.below.shape[1] - self.idle.shape[1])]

    def along(self, qdot: Array) -> Array:
        """The part of a joint motion that lower levels may not change, (n,)."""
        return self.taken.T @ (self.taken @ qdot)

    @property
    def measure(self) -> float:
        """√det of J N (J N)ᵀ: the product of m singular values, 0 if fewer than m are left."""
        return float(np.prod(self.s)) if self.rank == len(self.U) else 0.0

    @property
    def sigma_max(self) -> float:
        """The largest singular value of J itself, before any reduction."""
        return float(self.own[0])


@dataclass(frozen=True, eq=False)
class Freedom:
    """A subspace of joint motions that are free.

    Attributes:
        basis: Z, orthonormal columns, (n, d).
    """

    basis: Array

    @classmethod
    def whole(cls, n: int) -> Freedom:
        """All joint motions."""
        return cls(np.eye(n))

    def reduce(self, J: Array, release: float = 0.0) -> Reduced:
        """J in this freedom, and the freedom that is left below the level.

        The freedom below has the motions that do not move the level, exactly and undamped. Directions of small σ are
        not left to lower levels either, unless σ ≤ release·σ₁(J), so that the freedom below does not depend on how
        small σ is.

        Source: Kim, Marani, Chung, Yuh, eq. (13)-(15), with the projector in factored form.
        """
        n, d = self.basis.shape
        if d == 0:
            nothing = np.zeros((len(J), 0)), np.zeros(0), np.zeros((0, n))
            return Reduced(*nothing, singular_values(J), self.basis, self.basis, 0)
        found = full_svd(J if d == n else J @ self.basis)
        own = found.s if d == n else singular_values(J)
        rank = int(np.count_nonzero(found.s > RANK_TOLERANCE * own[0]))
        closed = int(np.count_nonzero(found.s > max(release, RANK_TOLERANCE) * own[0]))
        s = found.s if d == n else np.where(np.arange(len(found.s)) < rank, found.s, 0.0)
        directions = found.Vt if d == n else found.Vt @ self.basis.T
        return Reduced(found.U, s, directions[: len(s)], own, directions[closed:].T, directions[rank:].T, rank)

    def project(self, qdot: Array) -> Array:
        """The part of a joint motion that lies in this subspace."""
        return self.basis @ (self.basis.T @ qdot) if self.basis.shape[1] < len(qdot) else qdot
