"""Steps along a stratum: tangent spaces, projection back onto it, walks along it. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.kinematics.svd import singular_values, svd
from robust_ik.singularities.find.projection_search import SearchEnds, project
from robust_ik.singularities.find.rank_residual import Residual
from robust_ik.singularities.geometry.screw_chain import ScrewChain

Mask = NDArray[np.bool_]
Indices = NDArray[np.int_]

WEAK, STRONG = 1e-10, 1e-5
"""Singular values of ∂r/∂q, relative to σ₁, are zero below WEAK and not zero above STRONG. A point is readable if it
has none in between; others lie too close to a crossing of strata.
"""

POLISHED = 1e-14
"""‖r‖/σ₁ to be reached by polishing."""
REFUSED = 1 / 3
"""A step is refused if its corrector is longer than this fraction of its predictor: it may have changed the stratum."""
STRAIGHT = 0.8
"""Least cosine between the direction of a step and the next tangent space."""
WANDER = 0.3
"""Random change of a walk's direction at each step, and after a refusal."""
STILL = 1e-6
"""A joint that moves less than this along a walk is pinned, rad or m."""


@dataclass(frozen=True, eq=False)
class Walk:
    """Walks from N points along their strata.

    Attributes:
        values: (N, steps + 1, n), the start first; after a refused step the walk takes another direction.
        moved: Largest distance of each joint from the start, (N, n).
        taken: Number of steps taken, (N,).
    """

    values: Array
    moved: Array
    taken: Indices


def tangents(chain: ScrewChain, values: Array, corank: int, dimensions: Indices) -> Array:
    """Projectors (N, n, n) onto the tangent spaces of strata of corank k at points (N, n) with known dimensions."""
    if len(values) == 0:
        return np.empty((0, chain.n, chain.n))
    return tangents_at(Residual.at(chain, values, corank), dimensions)


def tangents_at(residual: Residual, dimensions: Indices) -> Array:
    """The same from the residual at the N points."""
    return _along(svd(residual.derivative).Vt, dimensions)


def _along(normals: Array, dimensions: Indices) -> Array:
    """Projectors (N, n, n) onto the orthogonal complement of the first n − dimension rows of (N, r, n)."""
    count, n = normals.shape[1:]
    rows = normals * (np.arange(count) < (n - np.asarray(dimensions))[:, None])[..., None]
    return np.asarray(np.eye(n) - np.swapaxes(rows, 1, 2) @ rows)


def readable(chain: ScrewChain, values: Array, corank: int) -> tuple[Mask, Indices]:
    """Which polished points (N, n) have exactly the corank and a clear dimension, and the dimensions, (N,) each."""
    if len(values) == 0:
        return np.empty(0, dtype=bool), np.empty(0, dtype=int)
    return readable_at(Residual.at(chain, values, corank))


def readable_at(at: Residual) -> tuple[Mask, Indices]:
    """The same from the residual at the N points."""
    return _read(at, singular_values(at.derivative))


def _read(at: Residual, a: Array) -> tuple[Mask, Indices]:
    a = a / np.maximum(at.scale[:, None], 1e-300)
    rank = np.sum(a > STRONG, axis=1)
    clear = (np.sum(a > WEAK, axis=1) == rank) & (rank > 0) & (at.coranks == at.corank)
    return np.asarray(clear), np.asarray(at.derivative.shape[-1] - rank)


def relative_sigmas(chain: ScrewChain, values: Array) -> Array:
    """σ/σ₁ at joint values (N, n), (N, m)."""
    s = svd(chain.jacobian(values)).s
    scale = np.maximum(s[:, :1], chain.least_scale)
    return np.asarray(s / np.where(scale > 0, scale, 1.0))


def polished(chain: ScrewChain, values: Array, corank: int, tolerance: float = POLISHED) -> Array:
    """The nearest points of corank k, by a few damped Newton steps, (N, n); unchanged if none is near."""
    if len(values) == 0:
        return values
    return np.asarray(project(chain, corank, values, tolerance).values)


def polish(chain: ScrewChain, values: Array, corank: int) -> SearchEnds:
    """`polished` with the residual at the points that are reached; of at least one point."""
    return project(chain, corank, values, POLISHED)


def walk(
    chain: ScrewChain,
    values: Array,
    corank: int,
    dimensions: Indices,
    rng: np.random.Generator,
    *,
    steps: int = 16,
    length: float = 0.2,
    resting: Sequence[int] = (),
) -> Walk:
    """Predictor and corrector along the strata, each walk in its own direction.

    Args:
        chain: What moves the tip.
        values: Start points, of exactly corank k, (N, n).
        corank: k.
        dimensions: Dimensions of the strata at the points, (N,).
        rng: Random numbers for the directions.
        steps: Number of steps.
        length: Length of a step, rad or m.
        resting: Free joints that do not move.
    """
    motion = np.ones(chain.n)
    motion[list(resting)] = 0.0
    here, heading = values.copy(), motion * rng.standard_normal(values.shape)
    path, taken = [values], np.zeros(len(values), dtype=int)
    offset, moved = np.zeros_like(values), np.zeros_like(values)
    if len(values) == 0:
        return Walk(np.empty((0, steps + 1, chain.n)), moved, taken)
    P = tangents(chain, here, corank, dimensions)
    labels = still_joints(P)
    for _ in range(steps):
        along = _units((P @ heading[..., None])[..., 0])
        ends = polish(chain, here + length * along, corank)
        there = ends.values
        P_there, fits = _seen(ends.residual, dimensions)
        allowed = fits & (np.linalg.norm(there - here - length * along, axis=1) <= REFUSED * length)
        allowed &= (still_joints(P_there) == labels).all(axis=1)
        allowed &= np.linalg.norm((P_there @ along[..., None])[..., 0], axis=1) > STRAIGHT
        offset += np.where(allowed[:, None], there - here, 0.0)
        here = np.where(allowed[:, None], there, here)
        P = np.where(allowed[:, None, None], P_there, P)
        moved = np.maximum(moved, np.abs(offset))
        taken += allowed
        heading = np.where(allowed[:, None], along, 0.0) + WANDER * motion * rng.standard_normal(values.shape)
        path.append(here)
    return Walk(np.stack(path, axis=1), moved, taken)


def still_joints(P: Array) -> Mask:
    """Joints that tangent spaces with projectors (N, n, n) do not move, (N, n); the same all over a stratum."""
    return np.asarray(np.diagonal(P, axis1=1, axis2=2) < STILL**2)


def _units(vectors: Array) -> Array:
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(size > 0, size, 1.0))


def _seen(at: Residual, dimensions: Indices) -> tuple[Array, Mask]:
    """The tangent spaces as projectors, and which points are clear, of exactly this corank and dimension."""
    found = svd(at.derivative)
    clear, its = _read(at, found.s)
    return _along(found.Vt, dimensions), clear & (its == dimensions)
