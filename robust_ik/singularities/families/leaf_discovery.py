"""Finds leaves from points of one corank: which joints are free, pinned, coupled, and how. Arrays only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.singularities.conditions.angle_sums import single, wrapped
from robust_ik.singularities.families.coupled_joints import coupled_leaves
from robust_ik.singularities.families.leaf import Leaf, Pin, is_singular
from robust_ik.singularities.find.rank_residual import Residual
from robust_ik.singularities.find.tangent_walk import STILL, Walk, polish, readable_at, still_joints, tangents_at, walk
from robust_ik.singularities.geometry.screw_chain import ScrewChain

Mask = NDArray[np.bool_]
Indices = NDArray[np.int_]

REPRESENTATIVES = 3
"""Points of a group from which walks start. Chosen: one alone may lie too near to a crossing."""
MANY_GROUPS = 200
"""Most groups with REPRESENTATIVES points; with more groups one point of each. Chosen: limits the time of walks."""
SAME_VALUE = 1e-4
"""Difference up to which pinned joints of one leaf agree at unpolished points, rad or m."""


@dataclass(frozen=True, eq=False)
class Labelled:
    """Points of exactly one corank, with labels of every joint from the tangent spaces.

    Attributes:
        values: (N, n).
        dimensions: (N,).
        still: Joints that the tangent space does not move, (N, n).
        loose: Joints that it moves alone, (N, n).
    """

    values: Array
    dimensions: Indices
    still: Mask
    loose: Mask

    def select(self, which: Array) -> Labelled:
        """A selection of the points."""
        return Labelled(self.values[which], self.dimensions[which], self.still[which], self.loose[which])


def labelled(values: Array, at: Residual, dimensions: Indices) -> Labelled:
    """Labels of readable points (N, n) from the tangent spaces there, which the residual gives."""
    P = tangents_at(at, dimensions)
    return Labelled(values, dimensions, still_joints(P), np.diagonal(P, axis1=1, axis2=2) > 1 - 1e-8)


def discover(chain: ScrewChain, values: Array, corank: int, rng: np.random.Generator) -> list[Leaf]:
    """The leaves that points of one corank lie on.

    Args:
        chain: What moves the tip.
        values: Points, (N, n); those without a clear tangent space are skipped.
        corank: k.
        rng: Random numbers for walks and trial motions.
    """
    if len(values) == 0:
        return []
    ends = polish(chain, values, corank)
    clear, dimensions = readable_at(ends.residual)
    if not clear.any():
        return []
    points = labelled(ends.values[clear], ends.residual.select(np.flatnonzero(clear)), dimensions[clear])
    groups = list(_groups(chain, points))
    each = REPRESENTATIVES if len(groups) <= MANY_GROUPS else 1
    first = np.concatenate([members[:each] for members in groups])
    owner = np.concatenate([np.full(len(members[:each]), i) for i, members in enumerate(groups)])
    seeds = points.select(first)
    walked = walk(chain, seeds.values, corank, seeds.dimensions, rng)
    seeds = replace(seeds, still=walked.moved < STILL, loose=_free_by_deed(chain, seeds, corank, rng))
    leaves: list[Leaf] = []
    for gathered in _gathered(chain, corank, points, groups, seeds, owner, walked):
        leaves += coupled_leaves(chain, gathered, rng)
    return leaves


def _groups(chain: ScrewChain, points: Labelled) -> Iterator[Indices]:
    """Indices of points with the same dimension, labels and pinned values, group by group."""
    keys = _keys(chain, points)
    _, inverse = np.unique(keys, axis=0, return_inverse=True)
    order = np.argsort(inverse.ravel(), kind="stable")
    yield from np.split(order, np.flatnonzero(np.diff(inverse.ravel()[order])) + 1)


def _keys(chain: ScrewChain, points: Labelled) -> Indices:
    columns = [points.dimensions[:, None], points.still.astype(int), points.loose.astype(int)]
    for joint in range(chain.n):
        still = points.still[:, joint]
        cluster = np.full(len(still), -1)
        cluster[still] = clusters(points.values[still, joint], float(chain.period[joint]))
        columns.append(cluster[:, None])
    return np.concatenate(columns, axis=1)


def clusters(values: Array, period: float) -> Indices:
    """The number of its cluster, from 0, for each of the values (N,), modulo the period."""
    if len(values) == 0:
        return np.empty(0, dtype=int)
    # Shifted by an odd amount, so that no usual angle lies at the end of the period.
    shifted = np.asarray(wrapped(values - 0.7654, period))
    order = np.argsort(shifted, kind="stable")
    numbers = np.empty(len(values), dtype=int)
    numbers[order] = np.concatenate([[0], np.cumsum(np.diff(shifted[order]) > SAME_VALUE)])
    return numbers


def _free_by_deed(chain: ScrewChain, seeds: Labelled, corank: int, rng: np.random.Generator) -> Mask:
    """Joints that can be moved anywhere, alone and then together, without lowering the corank, (N, n)."""
    free = seeds.loose.copy()
    for joint in range(chain.n):
        for _ in range(2):
            trial = seeds.values.copy()
            trial[:, joint] = chain.random(rng, len(trial))[:, joint]
            free[:, joint] &= is_singular(chain, trial, corank)
    together = np.where(free, chain.random(rng, len(free)), seeds.values)
    free[~is_singular(chain, together, corank)] = False
    return free


def _gathered(
    chain: ScrewChain,
    corank: int,
    points: Labelled,
    groups: list[Indices],
    seeds: Labelled,
    owner: Indices,
    walked: Walk,
) -> Iterator[Leaf]:
    """Incomplete leaves, from all groups whose representatives have the same labels; their walks come first."""
    keys = _keys(chain, seeds)
    for key in np.unique(keys, axis=0):
        alike = np.flatnonzero((keys == key).all(axis=1))
        alike = alike[walked.taken[alike] > 0] if walked.taken[alike].any() else alike
        first = int(alike[0])
        free, still = np.flatnonzero(seeds.loose[first]), np.flatnonzero(seeds.still[first])
        members = np.concatenate([groups[index] for index in np.unique(owner[alike])])
        paths = walked.values[alike].reshape(-1, chain.n)
        yield Leaf(
            corank=corank,
            dimension=int(seeds.dimensions[first]),
            pins=tuple(Pin(single(chain, int(j)), float(seeds.values[first, j])) for j in still),
            relations=(),
            free=tuple(int(j) for j in free),
            curve=tuple(j for j in range(chain.n) if j not in free and j not in still),
            samples=np.concatenate([paths, points.values[members]]),
        )
