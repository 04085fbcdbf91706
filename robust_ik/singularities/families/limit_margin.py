"""The part of a leaf within the joint limits, and its margin to them. Arrays only."""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array
from robust_ik.singularities.conditions.angle_sums import wrapped
from robust_ik.singularities.families.leaf import Leaf, Pin
from robust_ik.singularities.find.tangent_walk import polished, readable, tangents
from robust_ik.singularities.geometry.screw_chain import ScrewChain

BEST = 12
"""Samples from which the slack of coupled joints is increased."""
CLIMBS, STEP = 20, 0.2
"""Steps of the ascent, and length of the first one, rad or m. Chosen: twenty halvings take it to 2e-7."""


def slack(values: Array, lower: Array, upper: Array, period: Array) -> Array:
    """How far inside its limits each joint can be, modulo whole turns, (..., n); negative outside.

    Args:
        values: Joint values, (..., n).
        lower: Lower limits, (n,), −∞ for none.
        upper: Upper limits, (n,).
        period: Periods, (n,), infinite for joints that slide.
    """
    both = np.isfinite(lower) & np.isfinite(upper)
    center = np.where(both, (np.where(both, lower, 0.0) + np.where(both, upper, 0.0)) / 2, 0.0)
    near = np.where(both, center + wrapped(values - center, period), values)
    inside = np.minimum(near - lower, upper - near)
    return np.asarray(np.where(~both & np.isfinite(period), np.inf, inside))


def pin_slack(pin: Pin, lower: Array, upper: Array) -> float:
    """The slack of a pinned angle, shared evenly by the joints of a sum."""
    joints, signs = list(pin.angle.joints), np.array(pin.angle.signs)
    ends = np.sort(np.stack([signs * lower[joints], signs * upper[joints]]), axis=0).sum(axis=1)
    alone = slack(np.array([pin.value]), ends[:1], ends[1:], np.array([pin.angle.period]))
    return float(alone[0]) / len(joints)


def margin(chain: ScrewChain, leaf: Leaf, lower: Array, upper: Array) -> float:
    """The least slack of the member farthest inside the limits; for coupled joints an estimate from below.

    Args:
        chain: What moves the tip.
        leaf: The leaf.
        lower: Lower limits, (n,), rad or m; −∞ for none.
        upper: Upper limits.
    """
    best = np.inf
    for joint in leaf.free:
        if np.isfinite(lower[joint]) and np.isfinite(upper[joint]):
            best = min(best, float(upper[joint] - lower[joint]) / 2)
    for pin in leaf.pins:
        best = min(best, pin_slack(pin, lower, upper))
    return min(best, _climbed(chain, leaf, list(leaf.coupled), lower, upper)) if leaf.coupled else best


def _climbed(chain: ScrewChain, leaf: Leaf, joints: list[int], lower: Array, upper: Array) -> float:
    """The largest value of the coupled joints' least slack that ascent from the best samples finds."""

    def least(values: Array) -> Array:
        return np.asarray(slack(values, lower, upper, chain.period)[:, joints].min(axis=1))

    order = np.argsort(-least(leaf.samples))[:BEST]
    here = np.array(leaf.samples[order])
    score, size = least(here), np.full(len(here), STEP)
    if not np.isfinite(score).all():
        return float(score.max())
    for _ in range(CLIMBS):
        towards = np.zeros_like(here)
        worst = np.array(joints)[np.argmin(slack(here, lower, upper, chain.period)[:, joints], axis=1)]
        index = np.arange(len(here))
        aim = (lower[worst] + upper[worst]) / 2 - here[index, worst]
        towards[index, worst] = np.sign(wrapped(aim, chain.period[worst]))
        P = tangents(chain, here, leaf.corank, np.full(len(here), leaf.dimension))
        along = (P @ towards[..., None])[..., 0]
        there = polished(chain, here + size[:, None] * along, leaf.corank)
        clear, _ = readable(chain, there, leaf.corank)
        better = clear & leaf.holds(there) & (least(there) > score)
        here[better], score = there[better], np.where(better, least(there), score)
        size *= np.where(better, 1.2, 0.5)
    return float(score.max())
