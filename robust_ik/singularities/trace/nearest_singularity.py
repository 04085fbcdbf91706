"""The nearest singular configuration of an atlas, and σ on the way to it. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.kinematics.svd import svd
from robust_ik.singularities.conditions.angle_sums import wrapped
from robust_ik.singularities.conditions.robot_facts import RobotFacts
from robust_ik.singularities.families.leaf import Leaf, is_singular
from robust_ik.singularities.families.stratum import Stratum
from robust_ik.singularities.find.tangent_walk import polished, tangents
from robust_ik.singularities.geometry.screw_chain import ScrewChain

SAMPLES = 12
"""Nearest samples from which walks to the nearest member start. Chosen: more avoid more local minima."""
APPROACHES, LONGEST = 30, 0.4
"""Most steps of these walks, and the longest step, rad or m. Chosen: half a turn takes eight; the others settle."""
PATH = 33
"""Points on the path that is shown, ends included. Chosen: 32 segments look smooth."""


@dataclass(frozen=True, eq=False)
class Nearest:
    """The nearest singular configuration, without regard to limits.

    Attributes:
        stratum: The stratum that it lies on.
        distance: Euclidean distance of the joint values, in rad and, for slides, in the arm's unit of length: 1 m for
            robots of usual size.
        values: Its joint values, within half a turn of the given ones, (n,).
        path: Joint values on the straight way there, (P, n).
        sigma: σ_{r−k+1} on the way, in the units of the Jacobian, (P,); zero at the end.
    """

    stratum: Stratum
    distance: float
    values: Array
    path: Array
    sigma: Array

    def __post_init__(self) -> None:
        for name in ("values", "path", "sigma"):
            object.__setattr__(self, name, readonly(getattr(self, name)))


def nearest(facts: RobotFacts, strata: Sequence[Stratum], values: Array) -> list[Nearest]:
    """For each stratum its nearest configuration, the nearest stratum first.

    Args:
        facts: The arm.
        strata: Rows of its atlas.
        values: Joint values, rad and m, (n,).
    """
    even, units, found = facts.measured_in(facts.units), facts.units, []
    told = replace(facts.chain, length_scale=facts.length_scale)
    for stratum in strata:
        leaves = stratum.measured_in(units, facts.symbols).leaves
        ends = [_nearest_on(even.chain, leaf, values / units) for leaf in leaves]
        away, end = min(((float(np.linalg.norm(each - values / units)), each) for each in ends), key=lambda one: one[0])
        path = values + np.linspace(0.0, 1.0, PATH)[:, None] * (end * units - values)
        sigma = svd(told.jacobian(path)).s[:, told.full_rank - stratum.corank]
        found.append(Nearest(stratum, away, end * units, path, sigma))
    return sorted(found, key=lambda each: (each.distance, -each.stratum.dimension))


def _nearest_on(chain: ScrewChain, leaf: Leaf, values: Array) -> Array:
    """The nearest member of a leaf; for coupled joints a local minimum, the best from several starts."""
    pinned = _least_move(leaf, values)
    if not leaf.relations and not leaf.curve:
        return pinned
    away = np.linalg.norm(wrapped(leaf.samples - values, chain.period)[:, _coupled(leaf)], axis=1)
    starts = values + wrapped(leaf.samples[np.argsort(away)[:SAMPLES]] - values, chain.period)
    starts[:, list(leaf.free)] = values[list(leaf.free)]
    return _approached(chain, leaf, np.concatenate([pinned[None], starts]), values)


def _coupled(leaf: Leaf) -> list[int]:
    return [joint for joint in range(leaf.samples.shape[1]) if joint not in leaf.free]


def _least_move(leaf: Leaf, values: Array) -> Array:
    """The joint values where the pins hold, with the least change."""
    if not leaf.pins:
        return values
    rows = np.stack([pin.angle.row(len(values)) for pin in leaf.pins])
    change = np.array([float(pin.angle.wrapped(pin.value - pin.angle.of(values))) for pin in leaf.pins])
    return np.asarray(values + rows.T @ np.linalg.solve(rows @ rows.T, change))


def _approached(chain: ScrewChain, leaf: Leaf, starts: Array, goal: Array) -> Array:
    """The best end of walks along the leaf towards a configuration."""
    here = polished(chain, starts, leaf.corank)
    fits = leaf.holds(here) & is_singular(chain, here, leaf.corank)
    here = here[fits] if fits.any() else goal + wrapped(leaf.samples - goal, chain.period)
    apart, size = np.linalg.norm(here - goal, axis=1), np.ones(len(here))
    for _ in range(APPROACHES):
        P = tangents(chain, here, leaf.corank, np.full(len(here), leaf.dimension))
        along = (P @ (goal - here)[..., None])[..., 0] * size[:, None]
        along *= np.minimum(1.0, LONGEST / np.maximum(np.linalg.norm(along, axis=1), 1e-12))[:, None]
        there = polished(chain, here + along, leaf.corank)
        closer = leaf.holds(there) & (np.linalg.norm(there - goal, axis=1) < apart)
        here[closer] = there[closer]
        apart = np.linalg.norm(here - goal, axis=1)
        size = np.where(closer, np.minimum(1.0, 1.5 * size), 0.5 * size)
    return np.asarray(here[int(np.argmin(apart))])
