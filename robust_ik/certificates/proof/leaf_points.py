"""Real points on the leaves of a proof, for comparison with lists of singular configurations. NumPy only."""

from __future__ import annotations

import numpy as np

from robust_ik.certificates.proof.proof_leaves import LeafPlace
from robust_ik.checks import Array

STEPS, DIFFERENCE = 30, 1e-6
"""Newton steps, each of at most half a radian: 7 bring any angle near, about 5 finish, the rest are for slow starts.

DIFFERENCE is the step of central differences, rad or m: near the cube root of ε, where their error is least.
"""
SOLVED = 1e-12
"""Largest magnitude of a relation's left side at a point on it."""
STARTS_PER_POINT = 2
"""Starts for each wanted point, since Newton's method fails from some. Chosen: fewer leave too few points."""


def members(place: LeafPlace, rng: np.random.Generator, count: int) -> Array:
    """Random real points of a place, (≤ count, n) rad or m: free joints anywhere, related ones by Newton's method.

    There are none if none exist, or if none was found: a relation need not have real roots.

    Args:
        place: A leaf of a proof at one real place of its field.
        rng: Random numbers for the free joints.
        count: Number of points wanted.
    """
    n = len(place.names)
    values = rng.uniform(-np.pi, np.pi, (count if not place.relations else STARTS_PER_POINT * count, n))
    pins = place.angles | place.lengths
    for joint, value in pins.items():
        values[:, joint] = value
    if not place.relations:
        return values
    moved = sorted({joint for each in place.relations for joint in each.joints} - set(pins))
    for _ in range(STEPS):
        far = np.abs(_sides(place, values)).max(axis=1) >= SOLVED
        if not far.any():
            break
        step = np.zeros((len(values), len(moved)))
        step[far] = _newton_step(place, values[far], moved)
        values[:, moved] -= step
    return np.asarray(values[np.abs(_sides(place, values)).max(axis=1) < SOLVED][:count])


def _sides(place: LeafPlace, values: Array) -> Array:
    """The left sides of all relations, (N, relations)."""
    return np.stack([each.value(values) for each in place.relations], axis=-1)


def _newton_step(place: LeafPlace, values: Array, moved: list[int]) -> Array:
    """The least change of the joints `moved` that makes the relations zero, to first order, (N, moved)."""
    slopes = []
    for joint in moved:
        step = DIFFERENCE * np.eye(values.shape[1])[joint]
        slopes.append((_sides(place, values + step) - _sides(place, values - step)) / (2 * DIFFERENCE))
    A = np.stack(slopes, axis=-1)  # (N, relations, moved)
    gram = A @ np.swapaxes(A, 1, 2) + 1e-14 * np.eye(A.shape[1])
    step = np.swapaxes(A, 1, 2) @ np.linalg.solve(gram, _sides(place, values)[..., None])
    return np.asarray(np.clip(step[..., 0], -0.5, 0.5))
