"""A smooth round trip through a family of singular configurations, for display. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.singularities.conditions.robot_facts import RobotFacts
from robust_ik.singularities.families.leaf import Leaf
from robust_ik.singularities.families.limit_margin import angle_slack, slack
from robust_ik.singularities.families.stratum import Stratum
from robust_ik.singularities.find.tangent_walk import relative_sigmas
from robust_ik.singularities.geometry.screw_chain import ScrewChain
from robust_ik.singularities.trace.coupled_curves import Curve
from robust_ik.singularities.trace.paths_within_limits import EDGE, coupled_path

SWING, SLIDE = 0.6, 0.6
"""Largest swing of a free joint: rad, and as a fraction of the room within its limits."""
TRIES = 24
"""Number of choices of phases, of which the one that stays farthest from a higher corank is used."""
ROUNDING = 1e-9
"""Rounding of a joint that is pinned at its limit, rad or m."""


@dataclass(frozen=True, eq=False)
class Stroll:
    """A round trip.

    Attributes:
        values: Joint values, rad or m, (F, n): the last pose is the first one.
        inside: Whether all of it lies within the joint limits.
    """

    values: Array
    inside: bool

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", readonly(self.values))


def stroll(facts: RobotFacts, stratum: Stratum, curves: Sequence[Curve], rest: Array, frames: int) -> Stroll:
    """A round trip through a stratum, within the joint limits if part of it lies there.

    Free joints swing about a rest configuration; coupled joints go along a curve and, unless it closes, back.

    Args:
        facts: Facts of the robot.
        stratum: The stratum.
        curves: Its curves, from `trace`.
        rest: Joint values about which free joints swing, (n,).
        frames: Number of configurations, F.
    """
    leaf = _best_leaf(facts, stratum)
    path = coupled_path(facts, leaf, curves, frames)
    best, clearest = path, -1.0
    for attempt in range(TRIES):
        trial = _swung(facts, leaf, path, rest, attempt)
        apart = _apart(facts.chain, trial, stratum.corank)
        if apart > 1.2 * clearest:
            best, clearest = trial, apart
    return Stroll(best, within_limits(facts, best))


def within_limits(facts: RobotFacts, values: Array) -> bool:
    """Whether joint values (N, n) lie within the joint limits as they are, without whole turns."""
    return bool(np.all((values >= facts.lower - ROUNDING) & (values <= facts.upper + ROUNDING)))


def _best_leaf(facts: RobotFacts, stratum: Stratum) -> Leaf:
    """The leaf deepest inside the limits; among equals the one with the smallest angles."""

    def depth(leaf: Leaf) -> tuple[float, float]:
        slacks = (angle_slack(pin.angle, np.array([pin.value]), facts.lower, facts.upper) for pin in leaf.pins)
        room = min((float(each[0]) for each in slacks), default=np.inf)
        near = slack(leaf.samples, facts.lower, facts.upper, facts.chain.period)[:, list(leaf.coupled)]
        room = min(room, float(near.min(axis=1).max())) if leaf.coupled else room
        return min(room, EDGE), -sum(abs(pin.value) for pin in leaf.pins)

    return max(stratum.leaves, key=depth)


def _swung(facts: RobotFacts, leaf: Leaf, path: Array, rest: Array, attempt: int) -> Array:
    """The path with every free joint swinging once, each in its own phase."""
    phases = np.random.default_rng(attempt).uniform(0.0, 2 * np.pi, len(rest))
    values, turn = np.array(path), np.linspace(0.0, 2 * np.pi, len(path))
    for joint in leaf.free:
        low, high = float(facts.lower[joint]), float(facts.upper[joint])
        if not np.isfinite(high - low):
            low, high = rest[joint] - 4 * SWING, rest[joint] + 4 * SWING
        reach = min(SWING, SLIDE * (high - low) / 2)
        middle = min(max(float(rest[joint]), low + reach), high - reach)
        values[:, joint] = middle + reach * np.sin(turn + phases[joint])
    return values


def _apart(chain: ScrewChain, values: Array, corank: int) -> float:
    """The least σ_{m−k}/σ₁ on the way: the distance from a higher corank."""
    if corank >= chain.full_rank:
        return 1.0
    return float(relative_sigmas(chain, values)[:, chain.full_rank - corank - 1].min())
