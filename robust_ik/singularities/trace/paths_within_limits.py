"""Paths of coupled joints through a leaf, within the joint limits if possible. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robust_ik.checks import Array
from robust_ik.singularities.conditions.angle_sums import wrapped
from robust_ik.singularities.conditions.robot_facts import RobotFacts
from robust_ik.singularities.families.leaf import Leaf, Mask
from robust_ik.singularities.families.limit_margin import slack
from robust_ik.singularities.find.tangent_walk import polished
from robust_ik.singularities.trace.continuation import followed
from robust_ik.singularities.trace.coupled_curves import Curve

LONG, FAR = 1.2, 4.0
"""Length of a path of coupled joints with several degrees of freedom, and of one forth and back on a curve; rad, m."""
EDGE = 0.02
"""Distance kept from joint limits if there is room, rad or m."""


def coupled_path(facts: RobotFacts, leaf: Leaf, curves: Sequence[Curve], frames: int) -> Array:
    """Configurations of a leaf with coupled joints moving and pinned ones at their values, (frames, n)."""
    if not leaf.coupled:
        return np.repeat(_settled(facts, leaf, leaf.samples[:1]), frames, axis=0)
    own = [curve for curve in curves if curve.ordered and leaf.holds(curve.values).all()]
    if own:
        path, closed = _along_a_curve(facts, leaf, own)
    else:
        path, closed = _through_a_surface(facts, leaf), False
    path = _resampled(path, frames, closed)
    anew = polished(facts.chain, path, leaf.corank)
    anew[:, list(leaf.free)] = path[:, list(leaf.free)]
    return _settled(facts, leaf, anew)


def _settled(facts: RobotFacts, leaf: Leaf, values: Array) -> Array:
    """Values with pinned angles exact, all turned together by whole turns to lie between their limits."""
    values = leaf.pinned(values)
    center = _centers(facts, values.mean(axis=0))
    return np.asarray(values - (values[:1] - center - wrapped(values[:1] - center, facts.chain.period)))


def _centers(facts: RobotFacts, otherwise: Array) -> Array:
    both = np.isfinite(facts.lower) & np.isfinite(facts.upper)
    middle = (np.where(both, facts.lower, 0.0) + np.where(both, facts.upper, 0.0)) / 2
    return np.asarray(np.where(both, middle, wrapped(otherwise, facts.chain.period)))


def _room(facts: RobotFacts, leaf: Leaf, values: Array) -> Array:
    """Least slack of the coupled joints, (N,)."""
    return np.asarray(slack(values, facts.lower, facts.upper, facts.chain.period)[:, list(leaf.coupled)].min(axis=1))


def _along_a_curve(facts: RobotFacts, leaf: Leaf, curves: Sequence[Curve]) -> tuple[Array, bool]:
    """The longest path along a curve within the limits, or a whole closed curve; and whether it goes round."""
    best: tuple[int, Array, bool] | None = None
    for curve in curves:
        inside = _room(facts, leaf, curve.values) > EDGE
        if inside.all() and curve.closed and not _limited(facts, curve):
            return np.concatenate([curve.values, curve.values[-1:] + curve.chords[-1:]]), True
        run = _longest_run(inside, curve.closed)
        if best is None or len(run) > best[0]:
            best = len(run), _unbroken(facts, curve.values[run]) if len(run) > 1 else curve.values, False
    assert best is not None
    return best[1], best[2]


def _limited(facts: RobotFacts, curve: Curve) -> bool:
    """Whether a joint that makes a whole turn along the curve has limits, so that going round is impossible."""
    turned = np.abs(curve.values[-1] + curve.chords[-1] - curve.values[0]) > 1e-3
    return bool(np.any(turned & (np.isfinite(facts.lower) | np.isfinite(facts.upper))))


def _longest_run(inside: Mask, closed: bool) -> Array:
    """Indices of the longest run of points that are inside; on a closed curve it may pass the end."""
    count = len(inside)
    twice = np.concatenate([inside, inside]) if closed else inside
    edges = np.flatnonzero(np.diff(np.concatenate([[0], twice.astype(int), [0]])))
    if len(edges) == 0:
        return np.empty(0, dtype=int)
    begins, ends = edges[::2], edges[1::2]
    longest = int(np.argmax(ends - begins))
    return np.arange(begins[longest], min(ends[longest], begins[longest] + count)) % count


def _unbroken(facts: RobotFacts, values: Array) -> Array:
    """Consecutive values without jumps by whole turns."""
    steps = wrapped(np.diff(values, axis=0), facts.chain.period)
    return np.concatenate([values[:1], values[:1] + np.cumsum(steps, axis=0)])


def _through_a_surface(facts: RobotFacts, leaf: Leaf) -> Array:
    """The path straight on, both ways, from the sample deepest inside the limits until they end."""
    room = _room(facts, leaf, leaf.samples)
    start = leaf.pinned(leaf.samples[[int(np.argmax(np.minimum(room, 0.5)))]])
    start = _settled(facts, leaf, polished(facts.chain, start, leaf.corank))[0]
    ahead = followed(facts.chain, leaf, start, None, LONG / 2)
    back = followed(facts.chain, leaf, start, -ahead.heading, LONG / 2)
    return np.concatenate([_inner(facts, leaf, back.values)[:0:-1], _inner(facts, leaf, ahead.values)])


def _inner(facts: RobotFacts, leaf: Leaf, values: Array) -> Array:
    """The path up to where it leaves the limits; all of it if it begins outside."""
    inside = _room(facts, leaf, values) > 0
    return values if inside.all() or not inside[0] else values[: int(np.argmin(inside))]


def _resampled(path: Array, frames: int, closed: bool) -> Array:
    """A closed path at even spacing; another one there and back with smooth turns, (F, n)."""
    gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    turn = np.linspace(0.0, 1.0, frames)
    # Back and forth from the middle, so that the first configuration is not an end.
    there = gone[-1] * turn if closed else gone[-1] / 2 + min(gone[-1], FAR) / 2 * np.sin(2 * np.pi * turn)
    return np.stack([np.interp(there, gone, column) for column in path.T], axis=1)
