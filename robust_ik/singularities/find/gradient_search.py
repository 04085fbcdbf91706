"""The search of the paper, as a baseline: steepest descent of σ_{m−k+1}, with rotated clusters. NumPy only.

Two choices that the paper leaves open: σ within 2 % of each other are a cluster, and both one-dimensional searches, for
a step's length and for γ, are over grids.

Source: Almarkhi-Maciejewski, section 2.2, eqs. (11) to (14).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.svd import singular_values, svd
from robust_ik.singularities.find.projection_search import LONGEST_STEP, TOLERANCE, SearchEnds, project
from robust_ik.singularities.find.rank_residual import Indices, Residual
from robust_ik.singularities.geometry.screw_chain import ScrewChain

STEPS = 200
"""Most steps of a search. Chosen: where it succeeds, the median is up to 140 (docs/singularities.md)."""
FOUND = 1e-6
"""σ_{m−k+1} that counts as zero, the paper's ε; below it the point is polished."""
CLUSTER = 0.02
"""Relative difference of singular values up to which they are a cluster."""
PATIENCE = 3
"""Steps without descent after which a search ends.

Chosen: more take longer; the paper's claims are measured with 50.
"""
COARSE = 2.0 ** np.arange(2, -14, -1)
"""Lengths of steps to try, in units of the step that makes a linear σ zero."""
FINE = np.linspace(0.55, 1.9, 10)
"""Lengths to try next, in units of the best one."""
GAMMAS = np.linspace(0.0, 1.0, 6)
"""The grid for γ of (13). Chosen: each value costs a line search; finer ones take longer."""
ANGLES = np.linspace(0.0, np.pi / 2, 25)
"""The grid for the rotation of two clustered vectors, rad: a quarter turn swaps them. Chosen: steps of 3.75°."""
SWEEPS = 3
"""Sweeps over all pairs of a cluster of three or more. Chosen: turns of one pair move the others, but less and less."""


@dataclass(frozen=True, eq=False)
class Slope:
    """The k smallest singular values at N configurations, and their derivatives.

    Attributes:
        weakest: σ_{m−k+1} to σ_m, (N, k).
        block: u_aᵀ (∂J/∂q) v_b of their vectors, (N, k, k, n): ∂σ/∂q on the diagonal.
    """

    weakest: Array
    block: Array

    @classmethod
    def at(cls, chain: ScrewChain, values: Array, corank: int) -> Slope:
        """The slope at joint values (N, n)."""
        found = svd(chain.jacobian(values))
        right = np.swapaxes(found.Vt[:, chain.full_rank - corank :], -1, -2)
        return cls(
            found.s[:, chain.full_rank - corank :],
            chain.contraction(values, found.U[..., chain.full_rank - corank :], right),
        )

    @property
    def cluster(self) -> Indices:
        """How many singular values are near the target's, including itself, (N,)."""
        near = self.weakest >= (1 - CLUSTER) * self.weakest[:, :1]
        return np.asarray(np.sum(np.cumprod(near, axis=1), axis=1))


def gradient_search(
    chain: ScrewChain,
    corank: int,
    starts: Array,
    tolerance: float = TOLERANCE,
    *,
    rotated: bool = True,
    patience: int = PATIENCE,
) -> SearchEnds:
    """Steepest descent of σ_{m−k+1}; values below FOUND are polished to the tolerance.

    Args:
        chain: What moves the tip.
        corank: k.
        starts: Joint values, (N, n).
        tolerance: ‖r‖/σ₁ that counts as zero.
        rotated: Whether clusters are rotated and combined; otherwise the gradient is that of the arbitrary vectors of
            the SVD.
        patience: Steps without descent after which a search is given up.
    """
    values = starts.copy()
    target = _targets(chain, values, corank)
    idle, tries = np.zeros((2, len(values)), dtype=int)
    for _ in range(STEPS):
        active = np.flatnonzero((target > FOUND) & (idle < patience))
        if active.size == 0:
            break
        slope = Slope.at(chain, values[active], corank)
        along = directions(chain, values[active], slope, rotated=rotated)
        values[active], lower = line_search(chain, values[active], corank, slope.weakest[:, 0], along)
        idle[active] = np.where(lower < 0.999 * target[active], 0, idle[active] + 1)
        target[active] = lower
        tries[active] += 1
    ended = SearchEnds(values, Residual.at(chain, values, corank), tries, np.zeros(len(values), dtype=bool))
    near = np.flatnonzero(target <= FOUND)
    polished = project(chain, corank, values[near], tolerance)
    ended.put(near, replace(polished, tries=np.zeros(len(near), dtype=int)), polished.converged)
    return ended


def _targets(chain: ScrewChain, values: Array, corank: int) -> Array:
    """σ_{m−k+1}, (..., n) → (...)."""
    return np.asarray(singular_values(chain.jacobian(values))[..., chain.full_rank - corank])


def directions(chain: ScrewChain, values: Array, slope: Slope, *, rotated: bool = True) -> Array:
    """The gradient in eq. (11) at each of the values: ∂σ_{m−k+1}/∂q, within clusters eq. (13), (N, n)."""
    corank = slope.weakest.shape[1]
    chosen = slope.block[:, 0, 0].copy()
    clusters = slope.cluster
    for size in range(2, corank + 1 if rotated else 0):
        which = np.flatnonzero(clusters == size)
        if which.size:
            gradients = rotated_gradients(slope.block[which, :size, :size])
            chosen[which] = _combined(chain, values[which], corank, slope.weakest[which, 0], gradients)
    return chosen


def line_search(
    chain: ScrewChain, values: Array, corank: int, sigma: Array, directions: Array, *, refine: bool = True
) -> tuple[Array, Array]:
    """The points along −directions with the least σ_{m−k+1}, and its values there; no step if it falls nowhere."""
    squared = np.sum(directions**2, axis=1)
    unit = directions * (sigma / np.where(squared > 0, squared, 1.0))[:, None]
    longest = np.abs(unit).max(axis=1, keepdims=True)
    unit = unit * (LONGEST_STEP / COARSE[0] / np.maximum(longest, LONGEST_STEP / COARSE[0]))
    lengths = np.broadcast_to(COARSE, (len(values), len(COARSE)))
    best, least, everything = values, sigma, np.arange(len(values))
    for _ in range(1 + refine):
        trials = values[:, None] - lengths[..., None] * unit[:, None]
        found = _targets(chain, trials, corank)
        first = np.argmin(found, axis=1)
        better = found[everything, first] < least
        best = np.where(better[:, None], trials[everything, first], best)
        least = np.where(better, found[everything, first], least)
        lengths = lengths[everything, first][:, None] * FINE
    return best, least


def rotated_gradients(block: Array) -> Array:
    """The gradients of clustered singular values, in the bases in which their directions agree best.

    Pairs (u, v) are rotated by eq. (12), plane by plane, to the least sum of angles, eq. (14).

    Args:
        block: u_aᵀ (∂J/∂q) v_b within the clusters, (N, c, c, n).

    Returns:
        (N, c, n).
    """
    block = block.copy()
    size = block.shape[1]
    for _ in range(1 if size == 2 else SWEEPS):
        for a in range(size):
            for b in range(a + 1, size):
                block = _turned(block, a, b)
    return np.asarray(np.einsum("naak->nak", block))


def _turned(block: Array, a: int, b: int) -> Array:
    """The blocks (N, c, c, n) after the best rotation of ANGLES in the plane of pairs a and b."""
    turn = np.broadcast_to(np.eye(block.shape[1]), (len(ANGLES), block.shape[1], block.shape[1])).copy()
    turn[:, a, a] = turn[:, b, b] = np.cos(ANGLES)
    turn[:, a, b], turn[:, b, a] = np.sin(ANGLES), -np.sin(ANGLES)
    turned = np.einsum("pac,ncdk,pbd->npabk", turn, block, turn, optimize=True)
    gradients = np.einsum("npaak->npak", turned)
    unit = gradients / np.maximum(np.linalg.norm(gradients, axis=-1, keepdims=True), 1e-300)
    angles = np.arccos(np.clip(unit @ np.swapaxes(unit, -1, -2), -1.0, 1.0))
    return np.asarray(turned[np.arange(len(block)), np.argmin(angles.sum(axis=(-2, -1)), axis=1)])


def _combined(chain: ScrewChain, values: Array, corank: int, sigma: Array, gradients: Array) -> Array:
    """The gradients (N, c, n) combined to one by eq. (13), with each γ that leads to the least σ_{m−k+1}."""
    direction = gradients[:, 0]
    for other in np.moveaxis(gradients[:, 1:], 1, 0):
        tried = [gamma * direction + (1 - gamma) * other for gamma in GAMMAS]
        least = [line_search(chain, values, corank, sigma, each, refine=False)[1] for each in tried]
        direction = np.stack(tried)[np.argmin(least, axis=0), np.arange(len(values))]
    return np.asarray(direction)
