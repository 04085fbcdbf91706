"""Members of a leaf found from its conditions alone, not from its samples. Arrays only."""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array
from robust_ik.singularities.families.leaf import Leaf
from robust_ik.singularities.geometry.screw_chain import ScrewChain

STEPS, DIFFERENCE, LONGEST = 30, 1e-6, 0.5
SOLVED = 1e-11
"""Size of all conditions at a point that fulfils them."""
SMALL = 1e-6
"""Slopes below this part of the largest one do not lead anywhere."""


def solved(chain: ScrewChain, leaf: Leaf, rng: np.random.Generator, count: int) -> Array:
    """Joint values at which a leaf's pins and relations hold, (≤ count, n), by Newton's method from anywhere.

    They are members only if its conditions are enough: none are given for a curve, which has no equations.

    Args:
        chain: What moves the tip.
        leaf: The leaf.
        rng: For the starts.
        count: How many starts.
    """
    if leaf.curve:
        return np.empty((0, chain.n))
    values = leaf.pinned(chain.random(rng, count))
    if not leaf.relations:
        return values
    for _ in range(STEPS):
        step = np.linalg.pinv(_slopes(leaf, values), rcond=SMALL) @ _sides(leaf, values)[..., None]
        values = values - np.clip(step[..., 0], -LONGEST, LONGEST)
    return np.asarray(values[np.abs(_sides(leaf, values)).max(axis=1) < SOLVED])


def _sides(leaf: Leaf, values: Array) -> Array:
    """How far each pin and relation is from holding, (N, conditions)."""
    pins = [pin.angle.wrapped(pin.angle.of(values) - pin.value) for pin in leaf.pins]
    return np.stack([*pins, *(relation.of(values) for relation in leaf.relations)], axis=-1)


def _slopes(leaf: Leaf, values: Array) -> Array:
    """Their derivatives by the joints, (N, conditions, n)."""
    steps = DIFFERENCE * np.eye(values.shape[1])
    ends = [_sides(leaf, values + step) - _sides(leaf, values - step) for step in steps]
    return np.stack(ends, axis=-1) / (2 * DIFFERENCE)
