"""Splits a step into the singular directions of J, and classifies what an inverse does along each of them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.kinematics.svd import RANK_TOLERANCE, lost_directions, svd

EXACT_TO = 1e-6
"""Largest deviation, as a fraction of what is asked, at which a direction counts as exact or as cut."""

ASKED_FROM = 1e-9
"""Least fraction of ‖ẋ‖ at which a direction counts as asked; below it, given/asked would be rounding error."""


class Branch(StrEnum):
    """What an inverse does along one direction; the value is its label in the table."""

    EXACT = "exact"
    """What is asked is given."""
    DAMPED = "damped"
    """Some of it is given."""
    CUT = "cut"
    """Nothing of it is given, although joints could give it."""
    LOST = "lost"
    """σ = 0: no joint motion gives it."""
    AMPLIFIED = "amplified"
    """More than asked is given."""
    REVERSED = "reversed"
    """The opposite of what is asked is given."""
    UNASKED = "not asked"
    """Nothing is asked along it, and what the inverse would give is unknown."""


@dataclass(frozen=True, eq=False)
class Direction:
    """One singular direction of J, its pair (u, v) signed so that uᵀẋ ≥ 0.

    Attributes:
        sigma: Singular value; 0 for the task directions that n < m joints leave over.
        u: Task direction, (m,), a unit vector.
        v: Joint direction, (n,), a unit vector; zero if n < m leaves none.
        asked: uᵀẋ ≥ 0.
        given: uᵀJ q̇ = σ vᵀq̇.
        gain: φ(σ) of a filter, else None.
        fraction: Given over asked; for a filter σφ(σ), even if nothing is asked; None if unknown.
        speed: vᵀq̇, the joint speed along v.
        share: speed²/‖q̇‖².
        branch: The class of the direction.
        singular: Whether σ is at most the threshold of the explanation.
    """

    sigma: float
    u: Array
    v: Array
    asked: float
    given: float
    gain: float | None
    fraction: float | None
    speed: float
    share: float
    branch: Branch
    singular: bool

    @property
    def lost(self) -> float | None:
        """The fraction of what is asked that is not given: above 1 if reversed, negative if amplified."""
        return None if self.fraction is None else 1 - self.fraction


def take_apart(
    J: Array, xdot: Array, qdot: Array, threshold: float, gains: Array | None, *, follows: bool
) -> tuple[Direction, ...]:
    """The m task directions of J, by descending σ.

    Args:
        J: Jacobian, (m, n).
        xdot: Task velocity asked for, (m,).
        qdot: Joint velocities, (n,).
        threshold: σ up to which a direction counts as singular.
        gains: φ(σ), (k,), of a filter.
        follows: Whether q̇ results from ẋ by those gains, so that σφ(σ) is the fraction given.
    """
    U, s, V = _signed_pairs(J, xdot)
    total = float(np.linalg.norm(qdot))
    noise = ASKED_FROM * float(np.linalg.norm(xdot))
    directions = []
    for i, sigma in enumerate(s.tolist()):
        gain = float(gains[i]) if gains is not None and i < gains.size else None
        asked, speed = float(U[:, i] @ xdot), float(V[:, i] @ qdot)
        lost = sigma <= RANK_TOLERANCE * s[0]
        known = sigma * gain if follows and gain is not None else None
        measured = sigma * speed / asked if asked > noise else None
        fraction = 0.0 if lost else measured if known is None else known
        direction = Direction(
            sigma=sigma,
            u=readonly(U[:, i]),
            v=readonly(V[:, i]),
            asked=asked,
            given=sigma * speed,
            gain=gain,
            fraction=fraction,
            speed=speed,
            share=(speed / total) ** 2 if total > 0 else 0.0,
            branch=Branch.LOST if lost else _branch(fraction),
            singular=sigma <= threshold,
        )
        directions.append(direction)
    return tuple(directions)


def _signed_pairs(J: Array, xdot: Array) -> tuple[Array, Array, Array]:
    """U (m, m), σ (m,), V (n, m), padded with zeros to m, each pair signed so that uᵀẋ ≥ 0."""
    decomposition = svd(J)
    m, k = decomposition.U.shape
    U = np.hstack([decomposition.U, lost_directions(decomposition.U)])
    V = np.hstack([decomposition.Vt.T, np.zeros((J.shape[1], m - k))])
    asked = U.T @ xdot
    largest = U[np.argmax(np.abs(U), axis=0), np.arange(m)]
    sign = np.where(np.where(asked == 0, largest, asked) < 0, -1.0, 1.0)
    return U * sign, np.concatenate([decomposition.s, np.zeros(m - k)]), V * sign


def _branch(fraction: float | None) -> Branch:
    if fraction is None:
        return Branch.UNASKED
    if abs(fraction - 1) <= EXACT_TO:
        return Branch.EXACT
    if abs(fraction) <= EXACT_TO:
        return Branch.CUT
    if fraction < 0:
        return Branch.REVERSED
    return Branch.AMPLIFIED if fraction > 1 else Branch.DAMPED
