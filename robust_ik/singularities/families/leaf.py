"""Leaf: a part of a stratum with one value for every pinned angle, and members of it. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array, readonly
from robust_ik.singularities.conditions.angle_sums import Angle, brought, wrapped
from robust_ik.singularities.conditions.trig_relations import Relation
from robust_ik.singularities.find.rank_residual import SAME_CORANK
from robust_ik.singularities.find.tangent_walk import readable, relative_sigmas
from robust_ik.singularities.geometry.screw_chain import ScrewChain

Mask = NDArray[np.bool_]

HOLDS = 1e-5
"""Error of an angle or a relation up to which a point belongs to a stratum: polished points at crossings have it."""
EXACT = 1e-7
"""A pinned value this close to a multiple of π/12, or a length this close to zero, is replaced by it."""
CLEAN = 1e-9
"""Largest σ/σ₁ of members of a leaf, wherever their free joints are."""
FOLDED = 1e-12
"""The same if ∂r/∂q vanishes: an error δ of a value then only shows as δ²."""
FILLS, MOVES = 24, 12
"""Number of random members for a test, and for the test of each joint that is moved away."""
AWAY = 0.3
"""Least motion of a pinned joint, rad or m, in the test whether the singularity is left."""

STEPS, LONGEST, SETTLED = 30, 0.5, 1e-13
"""Most Newton steps; largest entry of a step, rad or m; entry of a step up to which no further one is taken.

Chosen: seven steps go half a turn, the others settle; longer steps would leap over solutions; values of a few radians
carry rounding of some 1e-15.
"""
SOLVED = 1e-11
"""Largest error of any condition at a solution."""
SMALL = 1e-6
"""Slopes below this fraction of the largest one count as zero."""


@dataclass(frozen=True, order=True)
class Pin:
    """One angle at one value, rad or m."""

    angle: Angle
    value: float

    def holds(self, values: Array, tolerance: float = HOLDS) -> Mask:
        """Whether the angle has the value at joint values (..., n)."""
        return np.asarray(np.abs(self.angle.wrapped(self.angle.of(values) - self.value)) <= tolerance)


def nice(angle: Angle, value: float, tolerance: float = EXACT) -> float:
    """The value, replaced by a multiple of π/12 (0 for a length) if it is one up to rounding, in (−π, π]."""
    value = float(angle.wrapped(value))
    exact = round(value * 12 / np.pi) * np.pi / 12 if angle.circular else 0.0
    return float(angle.wrapped(exact)) + 0.0 if abs(value - exact) < tolerance else value


@dataclass(frozen=True, eq=False)
class Leaf:
    """Configurations of one corank: pinned angles, related joints, free joints.

    Attributes:
        corank: k.
        dimension: Of the leaf.
        pins: Fixed angles, each with its value.
        relations: Short equations between coupled joints.
        free: Joints that may have any value, indices.
        curve: Joints that are coupled without a short relation.
        samples: Generic points, (S, n).
        folded: Whether ∂r/∂q vanishes along it, so that its tangent spaces cannot be computed.
    """

    corank: int
    dimension: int
    pins: tuple[Pin, ...]
    relations: tuple[Relation, ...]
    free: tuple[int, ...]
    curve: tuple[int, ...]
    samples: Array
    folded: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "samples", readonly(self.samples))

    @property
    def shape(self) -> tuple[object, ...]:
        """Everything that leaves of one row have in common: all but the values."""
        forms = tuple(relation.terms for relation in self.relations)
        return self.dimension, tuple(pin.angle for pin in self.pins), self.free, self.curve, forms

    @property
    def coupled(self) -> tuple[int, ...]:
        """Indices of joints that are neither free nor pinned by themselves."""
        alone = {pin.angle.joints[0] for pin in self.pins if len(pin.angle.joints) == 1}
        together = {joint for relation in self.relations for joint in relation.joints} | set(self.curve)
        together |= {joint for pin in self.pins if len(pin.angle.joints) > 1 for joint in pin.angle.joints}
        return tuple(sorted(together - alone))

    @cached_property
    def values(self) -> Array:
        """The pinned values, (P,)."""
        return np.array([pin.value for pin in self.pins])

    @cached_property
    def _pins(self) -> tuple[Array, Array]:
        """The pinned angles as combinations of joint values, (n, P), and their periods, (P,)."""
        n = self.samples.shape[1]
        rows = [pin.angle.row(n) for pin in self.pins]
        return np.array(rows).reshape(-1, n).T, np.array([pin.angle.period for pin in self.pins])

    @property
    def covectors(self) -> Array:
        """The derivatives of the pinned angles with respect to the joint values, (P, n)."""
        return self._pins[0].T

    def errors(self, values: Array) -> Array:
        """How far each pinned angle is from its value at joint values (N, n), (N, P)."""
        rows, period = self._pins
        return wrapped(values @ rows - self.values, period)

    def off(self, values: Array) -> Array:
        """The largest error of pins and relations at joint values (N, n), (N,)."""
        result = np.abs(self.errors(values)).max(axis=1, initial=0.0)
        for relation in self.relations:
            result = np.maximum(result, np.abs(relation.of(values)))
        return np.asarray(result)

    def holds(self, values: Array, tolerance: float = HOLDS) -> Mask:
        """Whether pins and relations hold at joint values (N, n); for the joints of a curve nothing is tested."""
        return np.asarray(self.off(values) <= tolerance)

    def pinned(self, values: Array) -> Array:
        """The values with every pinned angle exactly at its value, (N, n)."""
        return brought(values, [pin.angle for pin in self.pins], self.values)

    def filled(self, chain: ScrewChain, rng: np.random.Generator, count: int = FILLS, *, each: bool = False) -> Array:
        """Random members, (count, n): random samples (or with `each`, every sample once) with random free joints."""
        which = np.arange(count) if each else rng.integers(len(self.samples), size=count)
        values = np.array(self.samples[which])
        values[:, list(self.free)] = chain.random(rng, count)[:, list(self.free)]
        return self.pinned(values)


def explained(leaves: Sequence[Leaf], values: Array) -> Mask:
    """Which singular points (N, n) lie on some leaf."""
    result = np.zeros(len(values), dtype=bool)
    for leaf in leaves:
        result |= leaf.holds(values)
    return result


def is_singular(chain: ScrewChain, values: Array, corank: int) -> Mask:
    """Whether the corank is at least k at joint values (N, n)."""
    return np.asarray(relative_sigmas(chain, values)[:, chain.full_rank - corank] < SAME_CORANK)


def cleaned(chain: ScrewChain, leaf: Leaf, rng: np.random.Generator) -> Leaf:
    """The leaf without samples so close to a crossing that moving their free joints leaves it."""
    values = leaf.filled(chain, rng, len(leaf.samples), each=True)
    kept = relative_sigmas(chain, values)[:, chain.full_rank - leaf.corank] < CLEAN
    return replace(leaf, samples=leaf.samples[kept]) if kept.any() else leaf


def sound(chain: ScrewChain, leaf: Leaf, rng: np.random.Generator) -> bool:
    """Whether a leaf passes all tests: members singular for any values of free joints, and no needless condition."""
    return sound_each(chain, [leaf], rng)[0]


def sound_each(chain: ScrewChain, leaves: Sequence[Leaf], rng: np.random.Generator) -> list[bool]:
    """`sound` of each of some leaves of one corank, whose members are tested together."""
    result = verified(chain, leaves, rng)
    places = [place for place, good in enumerate(result) if good]
    for place, needless in zip(places, superfluous(chain, [leaves[place] for place in places], rng)):
        result[place] = not needless
    return result


def verified(chain: ScrewChain, leaves: Sequence[Leaf], rng: np.random.Generator) -> list[bool]:
    """Whether the conditions of leaves leave their dimensions, and random members have exactly corank and dimension."""
    places = [place for place, leaf in enumerate(leaves) if _fits(chain, leaf)]
    result = [False] * len(leaves)
    if not places:
        return result
    values = np.concatenate([leaves[place].filled(chain, rng) for place in places])
    weakest = chain.full_rank - leaves[0].corank
    sigmas = relative_sigmas(chain, values)
    exactly = sigmas[:, weakest - 1] >= SAME_CORANK if weakest else np.ones(len(values), dtype=bool)
    clear, dimensions = readable(chain, values, leaves[0].corank)
    for place, *parts in zip(places, *(np.split(each, len(places)) for each in (sigmas, exactly, clear, dimensions))):
        result[place] = _as_told(leaves[place], parts[0][:, weakest], *parts[1:])
    return result


def _fits(chain: ScrewChain, leaf: Leaf) -> bool:
    """Whether there are samples, and as many conditions as leave the dimension."""
    left = chain.n - len(leaf.pins) - len(leaf.relations)
    fits = leaf.dimension < left if leaf.curve else leaf.dimension == left
    return bool(fits and len(leaf.samples))


def _as_told(leaf: Leaf, lost: Array, exactly: Mask, clear: Mask, dimensions: Array) -> bool:
    """Whether random members of a leaf are as it tells.

    Args:
        leaf: The leaf.
        lost: The largest σ/σ₁ that its corank says is 0, (FILLS,).
        exactly: Whether the one before is not, (FILLS,).
        clear: Whether the dimension is clear, (FILLS,).
        dimensions: The dimensions, (FILLS,).
    """
    if not np.all(lost < (FOLDED if leaf.folded and not leaf.curve else CLEAN)):
        return False
    right = clear & (dimensions == leaf.dimension)
    readable_as_such = not right.any() if leaf.folded else bool(np.sum(right) > 0.8 * np.sum(clear) > 0)
    return bool(np.mean(exactly) > 0.8 and readable_as_such)


def superfluous(chain: ScrewChain, leaves: Sequence[Leaf], rng: np.random.Generator) -> list[list[int]]:
    """Of each leaf the joints in conditions that can be moved alone without lowering the corank: none if all count."""
    joints = [_bound(leaf) for leaf in leaves]
    moved = [_moved(chain, leaf, own, rng) for leaf, own in zip(leaves, joints)]
    if not moved:
        return []
    singular = is_singular(chain, np.concatenate(moved), leaves[0].corank)
    parts = np.split(singular, np.cumsum([len(each) for each in moved])[:-1])
    shares = [part.reshape(-1, MOVES).mean(axis=1) for part in parts]
    return [[joint for joint, still in zip(own, share) if still > 0.8] for own, share in zip(joints, shares)]


def _bound(leaf: Leaf) -> list[int]:
    """Joints in conditions."""
    bound = {joint for pin in leaf.pins for joint in pin.angle.joints} | set(leaf.curve)
    return sorted(bound | {joint for relation in leaf.relations for joint in relation.joints})


def _moved(chain: ScrewChain, leaf: Leaf, joints: Sequence[int], rng: np.random.Generator) -> Array:
    """Members with each of some joints moved away, (joints · MOVES, n)."""
    values = np.array(leaf.filled(chain, rng, MOVES * len(joints))).reshape(len(joints), MOVES, chain.n)
    for place, joint in enumerate(joints):
        span = chain.period[joint] if np.isfinite(chain.period[joint]) else 2 * AWAY + 1.0
        values[place, :, joint] += rng.uniform(AWAY, span - AWAY, MOVES)
    return values.reshape(-1, chain.n)


def solved(chain: ScrewChain, leaf: Leaf, rng: np.random.Generator, count: int) -> Array:
    """Joint values at which a leaf's pins and relations hold, (≤ count, n), by Newton's method from random starts.

    They are members only if its conditions are sufficient. There are none for a curve, which has no equations.

    Args:
        chain: What moves the tip.
        leaf: The leaf.
        rng: Random numbers for the starts.
        count: Number of starts.
    """
    if leaf.curve:
        return np.empty((0, chain.n))
    values = leaf.pinned(chain.random(rng, count))
    if not leaf.relations:
        return values
    active = np.arange(count)
    for _ in range(STEPS):
        here = values[active]
        step = np.linalg.pinv(_slopes(leaf, here), rcond=SMALL) @ _sides(leaf, here)[..., None]
        values[active] = here - np.clip(step[..., 0], -LONGEST, LONGEST)
        active = active[np.abs(step[..., 0]).max(axis=1) > SETTLED]
        if active.size == 0:
            break
    return np.asarray(values[np.abs(_sides(leaf, values)).max(axis=1) < SOLVED])


def _sides(leaf: Leaf, values: Array) -> Array:
    """Errors of each pin and relation, (N, conditions)."""
    return np.concatenate([leaf.errors(values), *(each.of(values)[:, None] for each in leaf.relations)], axis=1)


def _slopes(leaf: Leaf, values: Array) -> Array:
    """Their derivatives with respect to the joints, (N, conditions, n)."""
    pins = np.repeat(leaf.covectors[None], len(values), axis=0)
    return np.concatenate([pins, *(each.slopes(values)[:, None] for each in leaf.relations)], axis=1)
