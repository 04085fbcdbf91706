"""Finds all leaves of one corank from points: discovers, tests and completes them. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.singularities.families.degenerate_leaves import degenerate_leaves
from robust_ik.singularities.families.leaf import HOLDS, Leaf, cleaned, explained, sound_each
from robust_ik.singularities.families.leaf_discovery import discover
from robust_ik.singularities.families.leaf_guesses import completed
from robust_ik.singularities.families.leaf_merging import joined
from robust_ik.singularities.find.tangent_walk import Mask, polished, readable
from robust_ik.singularities.geometry.screw_chain import ScrewChain

AT_CROSSINGS = 2e-3
"""Distance at which points without a clear tangent space, near crossings, still count as on a leaf, rad or m."""
NEAR_CROSSINGS, BESIDE, MOSTLY = 0.01, 12, 0.7
"""At crossings of several strata points may be this far off, rad or m; of this many points around such a point, this
fraction must lead to known leaves for it to count as on one.
"""
SHAKE = 0.1
"""Standard deviation, rad or m, by which such points are moved. Chosen: ten times NEAR_CROSSINGS, and still nearby."""
ROUNDS = 3
"""Rounds in which points without a leaf are read. Chosen: the second and third read moved points; more take longer."""
KEPT = 400
"""Most samples of a leaf that are kept."""


@dataclass(frozen=True, eq=False)
class Survey:
    """The leaves that points of one corank led to.

    Attributes:
        leaves: The verified leaves.
        explained: Which points lie on one of them, or on a leaf of higher corank, (N,).
        rejected: How many leaves failed the verification.
    """

    leaves: tuple[Leaf, ...]
    explained: Mask
    rejected: int


def survey(
    chain: ScrewChain,
    corank: int,
    values: Array,
    rng: np.random.Generator,
    *,
    known: Sequence[Leaf] = (),
    higher: Sequence[Leaf] = (),
) -> Survey:
    """The leaves of one corank.

    Args:
        chain: What moves the tip.
        corank: k.
        values: Points whose corank is at least k, (N, n).
        rng: Random numbers for walks, members and shakes.
        known: Leaves of this corank that were found before.
        higher: Leaves of higher corank: points on them are accounted for.
    """
    leaves, rejected = list(known), 0
    accounted = accounts(chain, corank, [*leaves, *higher], values)
    for round_ in range(ROUNDS):
        rest = values[~accounted]
        if len(rest) == 0:
            break
        if round_ > 0:
            # Points without a clear tangent space may have one nearby.
            rest = polished(chain, rest + SHAKE * rng.standard_normal(rest.shape), corank)
        candidates = joined([cleaned(chain, leaf, rng) for leaf in discover(chain, rest, corank, rng)])
        leaves, failed = _found_anew(chain, leaves, candidates, rng)
        rejected += failed
        accounted = accounts(chain, corank, [*leaves, *higher], values)
    if not accounted.all():
        folded = [cleaned(chain, leaf, rng) for leaf in degenerate_leaves(chain, values[~accounted], corank, rng)]
        leaves, _ = _found_anew(chain, leaves, folded, rng)
        accounted = accounts(chain, corank, [*leaves, *higher], values)
    return Survey(tuple(replace(leaf, samples=leaf.samples[:KEPT]) for leaf in leaves), accounted, rejected)


def accounts(chain: ScrewChain, corank: int, leaves: Sequence[Leaf], values: Array) -> Mask:
    """Which points (N, n), of corank k at least, lie on one of the leaves.

    Points without a clear tangent space are matched with more tolerance. A curve has no equation: a point lies on it if
    its pins hold there, and, if the tangent space is clear, if the dimension is that of the curve. Where several strata
    cross, ‖r‖ is tiny even farther away from all of them: there it is tested where nearby points lead to.
    """
    result, plain = _on_leaves(chain, corank, leaves, values)
    doubtful = np.flatnonzero(~result & ~plain)
    near: Mask = np.zeros(len(doubtful), dtype=bool)
    for leaf in leaves:
        near |= leaf.holds(values[doubtful], NEAR_CROSSINGS)
    doubtful = doubtful[near]
    if doubtful.size:
        around = np.repeat(values[doubtful], BESIDE, axis=0)
        around = around + NEAR_CROSSINGS * np.random.default_rng(0).standard_normal(around.shape)
        led, _ = _on_leaves(chain, corank, leaves, polished(chain, around, corank))
        result[doubtful] = led.reshape(len(doubtful), BESIDE).mean(axis=1) > MOSTLY
    return result


def _on_leaves(chain: ScrewChain, corank: int, leaves: Sequence[Leaf], values: Array) -> tuple[Mask, Mask]:
    """Which points lie on one of the leaves, and which have a clear dimension not larger than that of the leaves."""
    clear, dimensions = readable(chain, values, corank)
    tolerance, result = np.where(clear, HOLDS, AT_CROSSINGS), np.zeros(len(values), dtype=bool)
    for leaf in leaves:
        left = np.flatnonzero(~result)
        fits = leaf.off(values[left]) <= tolerance[left]
        if leaf.curve and leaf.corank == corank:
            fits &= ~clear[left] | ((dimensions[left] == leaf.dimension) & (not leaf.folded))
        result[left] = fits
    largest = max((leaf.dimension for leaf in leaves), default=chain.n)
    return result, clear & (dimensions <= largest)


def _found_anew(
    chain: ScrewChain, leaves: Sequence[Leaf], candidates: Sequence[Leaf], rng: np.random.Generator
) -> tuple[list[Leaf], int]:
    """The leaves with those candidates that pass the tests, completed, and the number of those that do not pass."""
    good = [leaf for leaf, well in zip(candidates, sound_each(chain, candidates, rng)) if well]
    return uncovered(completed(chain, joined([*leaves, *good]), rng)), len(candidates) - len(good)


def uncovered(leaves: Sequence[Leaf]) -> list[Leaf]:
    """The leaves without curves whose samples all lie on leaves with equations."""
    related = [leaf for leaf in leaves if not leaf.curve]
    return [leaf for leaf in leaves if not _is_covered(leaf, related)]


def _is_covered(leaf: Leaf, others: Sequence[Leaf]) -> bool:
    """Whether a curve is the same as other leaves, which have equations: too few points to fit them were at hand."""
    same = [other for other in others if other.dimension == leaf.dimension]
    return bool(leaf.curve) and bool(explained(same, leaf.samples).all())
