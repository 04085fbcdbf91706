"""Leaves along which ∂r/∂q vanishes, as where two factors of a determinant meet for good: read by deed alone.

Their tangent spaces tell nothing, points reach them only slowly, and no walk stays on them. What is left is to move
joints and to see. Arrays only.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from robust_ik.checks import Array
from robust_ik.linalg import svd
from robust_ik.singularities.angles import candidates, single, wrapped
from robust_ik.singularities.kinematics import ScrewChain
from robust_ik.singularities.leaves import Leaf, Pin, is_singular, nice
from robust_ik.singularities.relations import Relation, simplest
from robust_ik.singularities.residual import Residual
from robust_ik.singularities.walking import Mask

ROUGH = 2e-3
"""Points that were reached slowly are this far off, rad or m."""
TRIALS = 3
MOSTLY = 0.8
MOST_COUPLED = 3
NEWTON, STEEP = 5, 1e-3
FEWEST = 3
"""Fewer points that agree are no family."""


def folded_leaves(chain: ScrewChain, values: Array, corank: int, rng: np.random.Generator) -> list[Leaf]:
    """Leaves of free, pinned and related joints that points (N, n) suggest which cannot be read; to be verified."""
    free = _free(chain, values, corank, rng)
    found = []
    for labels in np.unique(free, axis=0):
        members = values[(free == labels).all(axis=1)]
        pinned = [int(joint) for joint in np.flatnonzero(~labels) if _is_pinned(chain, members, int(joint))]
        while len(members) >= FEWEST and pinned:
            near = np.abs(wrapped(members - members[0], chain.period))[:, pinned].max(axis=1) < 2 * ROUGH
            if near.sum() >= FEWEST:
                found += _leaf(chain, members[near], corank, labels, pinned)
            members = members[~near]
    return found


def _is_pinned(chain: ScrewChain, members: Array, joint: int) -> bool:
    """Whether nearly all points share their value of a joint with others."""
    apart = np.abs(wrapped(members[:, None, joint] - members[None, :, joint], float(chain.period[joint])))
    return bool(np.mean(np.sum(apart < 2 * ROUGH, axis=1) >= min(FEWEST, len(members))) > MOSTLY)


def _free(chain: ScrewChain, values: Array, corank: int, rng: np.random.Generator) -> Mask:
    """Joints that can be moved alone without the corank falling, (N, n)."""
    free = np.ones(values.shape, dtype=bool)
    for joint in range(chain.n):
        for _ in range(TRIALS):
            trial = values.copy()
            trial[:, joint] = chain.random(rng, len(trial))[:, joint]
            free[:, joint] &= is_singular(chain, trial, corank)
    return free


def _leaf(chain: ScrewChain, members: Array, corank: int, labels: Mask, pinned: list[int]) -> list[Leaf]:
    """Pins at the middle of what members have, or at an exact value near it; for the rest one relation, or a curve.

    A curve's dimension is a guess: that there is one condition.
    """
    pins = []
    for joint in pinned:
        angle = single(chain, joint)
        middle = members[0, joint] + float(np.median(angle.wrapped(members[:, joint] - members[0, joint])))
        pins.append(Pin(angle, nice(angle, middle, ROUGH)))
    free = tuple(int(joint) for joint in np.flatnonzero(labels))
    coupled = [joint for joint in range(chain.n) if joint not in free and joint not in pinned]
    if coupled:
        members = _settled(chain, _moved(members, pins), corank, pinned)
    relation = _relation(chain, members, coupled) if coupled else None
    relations = () if relation is None else (relation,)
    curve = tuple(coupled) if relation is None else ()
    dimension = chain.n - len(pins) - bool(coupled)
    leaf = Leaf(corank, dimension, tuple(pins), relations, free, curve, members, folded=True)
    kept = leaf.holds(members, ROUGH)
    return [replace(leaf, samples=leaf.pinned(members[kept]))] if kept.any() else []


def _moved(values: Array, pins: list[Pin]) -> Array:
    for pin in pins:
        values = pin.angle.moved(values, pin.value)
    return values


def _settled(chain: ScrewChain, values: Array, corank: int, pinned: list[int]) -> Array:
    """Newton steps of the other joints in what is steep, the pinned ones staying where they are."""
    for _ in range(NEWTON):
        at = Residual.at(chain, values, corank)
        A = at.derivative.copy()
        A[..., pinned] = 0.0
        found = svd(A)
        steep = found.s > STEEP * at.s[:, :1]
        gain = np.where(steep, 1.0, 0.0) / np.where(steep, found.s, 1.0)
        values = values - np.einsum("nkj,nk,nik,ni->nj", found.Vt, gain, found.U, at.vector)
    return np.asarray(values)


def _relation(chain: ScrewChain, members: Array, coupled: list[int]) -> Relation | None:
    """One short relation between all of a few joints."""
    if not 2 <= len(coupled) <= MOST_COUPLED:
        return None
    angles = candidates(chain, coupled, members)
    choices = [
        each
        for size in range(2, len(coupled) + 1)
        for each in combinations(angles, size)
        if {joint for angle in each for joint in angle.joints} == set(coupled)
    ]
    return simplest(choices, members)
