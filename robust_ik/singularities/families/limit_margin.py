"""The margin of leaves to the joint limits. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robust_ik.checks import Array
from robust_ik.singularities.conditions.angle_sums import Angle, wrapped
from robust_ik.singularities.families.leaf import Leaf
from robust_ik.singularities.find.rank_residual import Residual
from robust_ik.singularities.find.tangent_walk import polish, readable_at, tangents_at
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


def angle_slack(angle: Angle, values: Array, lower: Array, upper: Array) -> Array:
    """The slack of an angle pinned at each of the values (V,), shared evenly by the joints of a sum, (V,)."""
    joints, signs = list(angle.joints), np.array(angle.signs)
    ends = np.sort(np.stack([signs * lower[joints], signs * upper[joints]]), axis=0).sum(axis=1)
    alone = slack(np.asarray(values)[:, None], ends[:1], ends[1:], np.array([angle.period]))
    return np.asarray(alone[:, 0] / len(joints))


def margins(chain: ScrewChain, leaves: Sequence[Leaf], lower: Array, upper: Array) -> list[float]:
    """For each leaf the least slack of the member farthest inside the limits; of coupled joints estimated from below.

    Args:
        chain: What moves the tip.
        leaves: The leaves of one row.
        lower: Lower limits, (n,), rad or m; −∞ for none.
        upper: Upper limits.
    """
    plain = [float(each) for each in _apart(leaves, lower, upper)]
    joints = list(leaves[0].coupled)
    if not joints:
        return plain
    return [min(pair) for pair in zip(plain, _climbed(chain, leaves, joints, lower, upper))]


def _apart(leaves: Sequence[Leaf], lower: Array, upper: Array) -> Array:
    """The least slack of free joints, which may be in the middle, and of pinned angles; infinite without limits.

    Args:
        leaves: The leaves of one row, which differ by their values.
        lower: Lower limits, (n,).
        upper: Upper limits.

    Returns:
        One for each leaf, (leaves,).
    """
    best = np.full(len(leaves), np.inf)
    for joint in leaves[0].free:
        if np.isfinite(lower[joint]) and np.isfinite(upper[joint]):
            best = np.minimum(best, (upper[joint] - lower[joint]) / 2)
    values = np.stack([leaf.values for leaf in leaves])
    for place, pin in enumerate(leaves[0].pins):
        best = np.minimum(best, angle_slack(pin.angle, values[:, place], lower, upper))
    return best


def _climbed(chain: ScrewChain, leaves: Sequence[Leaf], joints: list[int], lower: Array, upper: Array) -> list[float]:
    """The largest value of the coupled joints' least slack that ascent from the best samples finds, for each leaf."""

    def least(values: Array) -> Array:
        return np.asarray(slack(values, lower, upper, chain.period)[:, joints].min(axis=1))

    starts = [leaf.samples[np.argsort(-least(leaf.samples))[:BEST]] for leaf in leaves]
    ends = np.cumsum([len(each) for each in starts])[:-1]
    here = np.concatenate(starts)
    score, size = least(here), np.full(len(here), STEP)
    if not np.isfinite(score).all():
        return [float(each.max()) for each in np.split(score, ends)]
    at, dimensions = Residual.at(chain, here, leaves[0].corank), np.full(len(here), leaves[0].dimension)
    index = np.arange(len(here))
    for _ in range(CLIMBS):
        towards = np.zeros_like(here)
        worst = np.array(joints)[np.argmin(slack(here, lower, upper, chain.period)[:, joints], axis=1)]
        aim = (lower[worst] + upper[worst]) / 2 - here[index, worst]
        towards[index, worst] = np.sign(wrapped(aim, chain.period[worst]))
        along = (tangents_at(at, dimensions) @ towards[..., None])[..., 0]
        found = polish(chain, here + size[:, None] * along, leaves[0].corank)
        there, reached = found.values, least(found.values)
        holds = [leaf.holds(values) for leaf, values in zip(leaves, np.split(there, ends))]
        better = readable_at(found.residual)[0] & np.concatenate(holds) & (reached > score)
        here[better], score = there[better], np.where(better, reached, score)
        at.put(np.flatnonzero(better), found.residual.select(np.flatnonzero(better)))
        size *= np.where(better, 1.2, 0.5)
    return [float(each.max()) for each in np.split(score, ends)]
