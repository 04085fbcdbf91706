"""The Levenberg-Marquardt method for N searches at once. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.singularities.find.compiled_search import Rules, compiled_search
from robust_ik.singularities.find.rank_residual import Indices, Mask, Residual
from robust_ik.singularities.geometry.screw_chain import ScrewChain

TOLERANCE = 1e-11
"""‖r‖/σ₁ that counts as zero."""
STEPS = 60
"""Most steps of a search. Chosen: 4,800 searches on four arms, coranks 1 to 3, took up to 42."""
LONGEST_STEP = 0.5
"""Largest step of one joint, rad or m."""
FIRST_DAMPING, LESS, MORE = 0.1, 0.2, 4.0
"""Damping μ in units of ‖r‖σ₁: the first one, and its factors after steps that lower ‖r‖ and after others."""
WORTHWHILE, PATIENCE = 0.95, 6
"""A search stalls if PATIENCE steps together do not lower ‖r‖ by the factor WORTHWHILE."""


@dataclass(frozen=True, eq=False)
class SearchEnds:
    """The ends of N searches.

    Attributes:
        values: Joint values, (N, n).
        residual: The residual at these values.
        tries: Steps tried, (N,).
        converged: Whether ‖r‖ was brought to zero, (N,).
    """

    values: Array
    residual: Residual
    tries: Indices
    converged: Mask

    def copy(self) -> SearchEnds:
        """A writable copy."""
        everything = np.arange(len(self.values))
        return SearchEnds(
            self.values.copy(), self.residual.select(everything), self.tries.copy(), self.converged.copy()
        )

    def select(self, which: Indices) -> SearchEnds:
        """Some of the ends."""
        return SearchEnds(self.values[which], self.residual.select(which), self.tries[which], self.converged[which])

    def put(self, which: Indices, other: SearchEnds, better: Mask) -> None:
        """Replaces some ends by better ones of another search, and adds its steps to all.

        Args:
            which: For each end of the other search, its index here.
            other: The other search.
            better: Which of its ends to take.
        """
        self.tries[which] += other.tries
        self.values[which[better]] = other.values[better]
        self.converged[which[better]] = other.converged[better]
        self.residual.put(which[better], other.residual.select(np.flatnonzero(better)))


def project(chain: ScrewChain, corank: int, values: Array, tolerance: float = TOLERANCE) -> SearchEnds:
    """Steps from each of the joint values (N, n) until ‖r‖ ≤ tolerance σ₁ or no step helps."""
    rules = Rules(tolerance, STEPS, LONGEST_STEP, FIRST_DAMPING, LESS, MORE, WORTHWHILE, PATIENCE)
    found = compiled_search(chain, corank, values, rules)
    if found is None:
        return project_by_numpy(chain, corank, values, tolerance)
    residual = Residual(corank, found.s, found.derivative, found.scale, chain.full_rank)
    return SearchEnds(found.values, residual, found.tries.astype(int), residual.relative <= tolerance)


def project_by_numpy(chain: ScrewChain, corank: int, values: Array, tolerance: float = TOLERANCE) -> SearchEnds:
    """The same, step by step: the reference of compiled code, and for any number of joints."""
    values, tries = values.copy(), np.zeros(len(values), dtype=int)
    state = Residual.by_numpy(chain, values, corank)
    # Only searches that go on are kept at hand; the others lie at their ends.
    active = np.flatnonzero(state.relative > tolerance)
    q, here = values[active], state.select(active)
    norm, damping, idle = here.norm, np.full(len(active), FIRST_DAMPING), np.zeros(len(active), dtype=int)
    for _ in range(STEPS):
        if active.size == 0:
            break
        trial = q + step(here, damping * norm * here.scale)
        there = Residual.by_numpy(chain, trial, corank)
        after = there.norm
        tries[active] += 1
        idle = np.where(after < WORTHWHILE * norm, 0, idle + 1)
        lower = after < norm
        damping = damping * np.where(lower, LESS, MORE)
        if lower.all():
            q, here, norm = trial, there, after
        else:
            took = np.flatnonzero(lower)
            q[took], norm[took] = trial[took], after[took]
            here.put(took, there.select(took))
        going = (here.of_scale(norm) > tolerance) & (idle < PATIENCE)
        if not going.all():
            done, left = np.flatnonzero(~going), np.flatnonzero(going)
            values[active[done]] = q[done]
            state.put(active[done], here.select(done))
            active, q, here = active[left], q[left], here.select(left)
            norm, damping, idle = norm[left], damping[left], idle[left]
    values[active] = q
    state.put(active, here)
    return SearchEnds(values, state, tries, state.relative <= tolerance)


def step(at: Residual, mu: Array) -> Array:
    """−(AᵀA + μI)⁻¹Aᵀr, cut to LONGEST_STEP, (N, n).

    μ falls with ‖r‖, not with its square, because strata are rarely complete intersections: A has a null space there.

    Args:
        at: r and A = ∂r/∂q of N configurations.
        mu: damping ‖r‖ σ₁, (N,).
    """
    from robust_ik.kernels.matrices import steps

    count, p, n = at.derivative.shape
    size, result = min(p, n), np.empty((count, n))
    room = np.empty((size, size)), np.empty((1, size))
    steps(np.ascontiguousarray(at.derivative), np.ascontiguousarray(at.weakest), mu, LONGEST_STEP, *room, result)
    return result
