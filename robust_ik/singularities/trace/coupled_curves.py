"""The curves of a family of singular configurations: coupled joints, traced completely. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.singularities.conditions.angle_sums import wrapped
from robust_ik.singularities.conditions.robot_facts import RobotFacts
from robust_ik.singularities.families.leaf import Leaf, Mask, is_singular
from robust_ik.singularities.families.stratum import Stratum
from robust_ik.singularities.find.projection_search import project
from robust_ik.singularities.find.tangent_walk import polished, readable, still_joints, tangents, walk
from robust_ik.singularities.geometry.screw_chain import ScrewChain
from robust_ik.singularities.trace.continuation import STEP, followed, outside

SEEDS = 300
"""Random starts, besides the samples, for pieces without samples."""
ON = 5e-3
"""A seed closer to a curve than this lies on it, rad or m: chords between its points deviate by a tenth of that."""
WALKERS, STEPS = 40, 40
"""Number and steps of walks through a surface or a set of higher dimension."""


class OfArm(Protocol):
    """An object that knows the arm of its families: an atlas."""

    @property
    def robot(self) -> RobotFacts:
        """The arm."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A piece of a family, in the coupled joints; free joints do not move in it.

    Attributes:
        joints: The coupled joints, indices from 0.
        values: Joint values, rad or m, (N, n); angles continue beyond whole turns.
        closed: Whether the last point is followed by the first, modulo whole turns.
        ordered: Whether each point follows the one before; points of a surface have no order.
        period: Change of each joint value after which the pose is the same again, (n,).
    """

    joints: tuple[int, ...]
    values: Array
    closed: bool
    ordered: bool
    period: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", readonly(self.values))
        object.__setattr__(self, "period", readonly(self.period))

    @property
    def chords(self) -> Array:
        """Differences from each point of an ordered curve to the next, (N, n) if it is closed, else (N − 1, n)."""
        ends = np.roll(self.values, -1, axis=0) if self.closed else self.values[1:]
        return wrapped(ends - self.values[: len(ends)], self.period)

    def distance(self, values: Array) -> Array:
        """Distance of joint values (M, n) from it, in the coupled joints alone, (M,)."""
        ways = self.chords if self.ordered else np.zeros_like(self.values)
        away = wrapped(values[:, None] - self.values[: len(ways)], self.period)[..., list(self.joints)]
        ways = ways[:, list(self.joints)]
        share = np.sum(away * ways, axis=-1) / np.maximum(np.sum(ways**2, axis=-1), 1e-300)
        return np.asarray(np.linalg.norm(away - np.clip(share, 0, 1)[..., None] * ways, axis=-1).min(axis=1))


def trace(atlas: OfArm, stratum: Stratum) -> tuple[Curve, ...]:
    """The curves of the coupled joints of a stratum; none if no joints are coupled.

    If they have more than one degree of freedom, points spread over their set instead.

    Args:
        atlas: The atlas that holds it.
        stratum: One of its rows.
    """
    facts, units = atlas.robot, atlas.robot.units
    even = facts.measured_in(units)
    curves = [curve for leaf in stratum.measured_in(units, facts.symbols).leaves for curve in traced(even.chain, leaf)]
    return tuple(replace(curve, values=curve.values * units) for curve in curves)


def traced(chain: ScrewChain, leaf: Leaf) -> tuple[Curve, ...]:
    """The curves of one leaf."""
    if not leaf.coupled:
        return ()
    seeds = _seeds(chain, leaf)
    if leaf.dimension - len(leaf.free) > 1:
        return (_scattered(chain, leaf, seeds),)
    found: list[Curve] = []
    while len(seeds):
        curve = _curve(chain, leaf, seeds[0])
        if len(curve.values) > 2:
            found.append(curve)
            seeds = seeds[1:][curve.distance(seeds[1:]) > ON]
        else:
            seeds = seeds[1:]
    return tuple(found) or (_points(chain, leaf, leaf.pinned(leaf.samples)),)


def _curve(chain: ScrewChain, leaf: Leaf, start: Array) -> Curve:
    """The curve through a point, followed both ways until it closes or ends."""
    ahead = followed(chain, leaf, start)
    if ahead.closed:
        return Curve(leaf.coupled, ahead.values, True, True, chain.period)
    back = followed(chain, leaf, start, -ahead.heading)
    return Curve(leaf.coupled, np.concatenate([back.values[:0:-1], ahead.values]), False, True, chain.period)


def _points(chain: ScrewChain, leaf: Leaf, values: Array) -> Curve:
    return Curve(leaf.coupled, values, False, False, chain.period)


def _seeds(chain: ScrewChain, leaf: Leaf) -> Array:
    """Readable members of the leaf, free joints as in the first of them, (S, n)."""
    rng = np.random.default_rng(0)
    starts = leaf.pinned(chain.random(rng, SEEDS))
    found = project(chain, leaf.corank, starts)
    values = np.concatenate([leaf.samples, chain.wrapped(found.values[found.converged])])
    values = values[leaf.holds(values) & ~outside(chain, values)]
    values[:, list(leaf.free)] = leaf.samples[0, list(leaf.free)]
    values = leaf.pinned(polished(chain, values, leaf.corank))
    return values[_members(chain, leaf, values, rng)]


def _members(chain: ScrewChain, leaf: Leaf, values: Array, rng: np.random.Generator) -> Mask:
    """Which singular points lie on the leaf: same dimension, same free joints, same coupled joints."""
    clear, dimensions = readable(chain, values, leaf.corank)
    clear &= leaf.holds(values) & (dimensions == leaf.dimension)
    moved = np.array(values)
    moved[:, list(leaf.free)] = chain.random(rng, len(values))[:, list(leaf.free)]
    clear &= is_singular(chain, moved, leaf.corank)
    moving = ~still_joints(tangents(chain, values, leaf.corank, np.full(len(values), leaf.dimension)))
    expected = np.isin(np.arange(chain.n), (*leaf.free, *leaf.coupled))
    return np.asarray(clear & (moving == expected).all(axis=1))


def _scattered(chain: ScrewChain, leaf: Leaf, seeds: Array) -> Curve:
    """Points of walks spread over the set of coupled joints with several degrees of freedom."""
    starts = seeds if len(seeds) else leaf.pinned(leaf.samples)
    starts = starts[np.unique(np.linspace(0, len(starts) - 1, WALKERS).round().astype(int))]
    walked = walk(
        chain,
        starts,
        leaf.corank,
        np.full(len(starts), leaf.dimension),
        np.random.default_rng(0),
        steps=STEPS,
        length=3 * STEP,
        resting=leaf.free,
    )
    values = chain.wrapped(walked.values.reshape(-1, chain.n))
    return _points(chain, leaf, np.concatenate([seeds, values[replace(leaf, free=()).holds(values)]]))
