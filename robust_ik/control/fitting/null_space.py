"""The joint motions that higher levels leave free, and what a level can do with them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.svd import RANK_TOLERANCE, full_svd, singular_values


@dataclass(frozen=True, eq=False)
class Reduced:
    """J Z Zᵀ = U diag(s) Vt: a level's Jacobian in what is left; Z is the basis of what is left.

    Attributes:
        U: Task directions, (m, k) with k = min(m, d).
        s: Singular values, (k,), descending; those of rows that higher levels already fix are zero. Of the first level
            they are as found: by what is left of σ at a singularity, a filter leaves it.
        Vt: Joint directions as rows, (k, n), orthonormal.
        own: All singular values of J itself, descending.
        below: The basis of what the level leaves to lower ones, (n, d').
        idle: The basis of what moves the level nowhere, (n, d − rank), within `below`.
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
        """The joint directions that lower levels may not use, as rows: `motions` but for what is released or lost."""
        return self.Vt[: self.rank - (self.below.shape[1] - self.idle.shape[1])]

    def along(self, qdot: Array) -> Array:
        """The part of a joint motion that lower levels have no share in, (n,)."""
        return self.taken.T @ (self.taken @ qdot)

    @property
    def measure(self) -> float:
        """√det of J N (J N)ᵀ: the product of m singular values, 0 where fewer than m are left."""
        return float(np.prod(self.s)) if self.rank == len(self.U) else 0.0

    @property
    def sigma_max(self) -> float:
        """The largest singular value of J itself, before anything is taken away."""
        return float(self.own[0])


@dataclass(frozen=True, eq=False)
class Freedom:
    """A subspace of joint motions.

    Attributes:
        basis: Z, orthonormal columns, (n, d).
    """

    basis: Array

    @classmethod
    def whole(cls, n: int) -> Freedom:
        """All joint motions."""
        return cls(np.eye(n))

    def reduce(self, J: Array, release: float = 0.0) -> Reduced:
        """What of J is left, and what of the freedom is left then.

        What is left then are the motions that move the level nowhere, exactly and undamped. Directions of small σ are
        taken from lower levels too, unless σ ≤ release·σ₁(J), so that what is left does not depend on how small σ is.

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
        """The part of a joint motion that lies in it."""
        return self.basis @ (self.basis.T @ qdot) if self.basis.shape[1] < len(qdot) else qdot
