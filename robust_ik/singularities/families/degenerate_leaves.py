"""Leaves along which ∂r/∂q vanishes, for example a double factor of a determinant; they are found by trial motions.

Their tangent spaces give no information, searches approach them slowly, and no walk stays on them. What remains is to
move joints and test, and to compare points: angles whose values many points share are pinned. Arrays only.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.svd import svd
from robust_ik.singularities.conditions.angle_sums import Angle, brought, candidates
from robust_ik.singularities.conditions.relation_fitting import simplest
from robust_ik.singularities.conditions.trig_relations import Relation
from robust_ik.singularities.families.leaf import Leaf, Pin, is_singular, nice
from robust_ik.singularities.find.find_points import local_dimensions
from robust_ik.singularities.find.rank_residual import Residual
from robust_ik.singularities.find.tangent_walk import POLISHED, Mask, polished
from robust_ik.singularities.geometry.screw_chain import ScrewChain

ROUGH = 2e-3
"""Distance of slowly reached points from the leaf, rad or m."""
TRIALS = 3
"""Values that a joint is moved to; it is free if all are singular. Chosen: fewer rely on chance, more take longer."""
MOSTLY = 0.8
"""Fraction of points that must agree. Chosen: some points are off near crossings, most are not."""
MOST_COUPLED = 3
"""Most joints of a fitted relation. Chosen: more joints take more terms than such rough points can decide."""
NEWTON, STEEP = 5, 1e-3
"""Newton steps, and least σ of ∂r/∂q over σ₁ of a steep direction: `rank_residual.CLEAR`.

Chosen: from ROUGH five suffice.
"""
EXACTLY = 1e-12
"""Rounding of a multiple of π/12, rad."""
FEWEST = 3
"""Least number of points that make a family."""


def degenerate_leaves(chain: ScrewChain, values: Array, corank: int, rng: np.random.Generator) -> list[Leaf]:
    """Leaves of free, pinned and related joints, suggested by points (N, n) without clear tangents; to be verified."""
    values = polished(chain, values, corank)
    free = _free(chain, values, corank, rng)
    found = []
    for labels in np.unique(free, axis=0):
        members = values[(free == labels).all(axis=1)]
        pinned = _pinned(chain, members, [int(joint) for joint in np.flatnonzero(~labels)])
        while len(members) >= FEWEST and pinned:
            near = np.all(
                [Pin(angle, float(angle.of(members[0]))).holds(members, 2 * ROUGH) for angle in pinned], axis=0
            )
            if near.sum() >= FEWEST:
                found += _leaf(chain, members[near], corank, labels, pinned, rng)
            members = members[~near]
    return found


def _pinned(chain: ScrewChain, members: Array, joints: list[int]) -> list[Angle]:
    """Angles of joints, and sums of parallel ones, whose values nearly all points share with others."""
    found: list[Angle] = []
    for angle in candidates(chain, joints, members):
        rows = np.stack([each.row(chain.n) for each in (*found, angle)])
        if np.linalg.matrix_rank(rows) == len(rows) and _is_pinned(members, angle):
            found.append(angle)
    return found


def _is_pinned(members: Array, angle: Angle) -> bool:
    values = angle.of(members)
    apart = np.abs(angle.wrapped(values[:, None] - values[None]))
    return bool(np.mean(np.sum(apart < 2 * ROUGH, axis=1) >= min(FEWEST, len(members))) > MOSTLY)


def _free(chain: ScrewChain, values: Array, corank: int, rng: np.random.Generator) -> Mask:
    """Joints that can be moved alone without lowering the corank, (N, n)."""
    free = np.ones(values.shape, dtype=bool)
    for joint in range(chain.n):
        for _ in range(TRIALS):
            trial = values.copy()
            trial[:, joint] = chain.random(rng, len(trial))[:, joint]
            free[:, joint] &= is_singular(chain, trial, corank)
    return free


def _leaf(
    chain: ScrewChain,
    members: Array,
    corank: int,
    labels: Mask,
    pinned: list[Angle],
    rng: np.random.Generator,
) -> list[Leaf]:
    """A leaf from members: pins at their medians or nearby exact values; one relation or a curve for the other joints.

    Coupled joints do not determine the dimension, so it is measured around the members.
    """
    free = tuple(int(joint) for joint in np.flatnonzero(labels))
    spoken = {*free, *(joint for angle in pinned for joint in angle.joints)}
    coupled = [joint for joint in range(chain.n) if joint not in spoken]
    members, pins = _pins(chain, members, corank, pinned)
    dimension = chain.n - len(pins)
    if coupled:
        measured = local_dimensions(chain, corank, members, rng, POLISHED)
        dimension = int(np.bincount(measured).argmax())
        members = members[measured == dimension]
    if len(members) < FEWEST:
        return []
    single = dimension == chain.n - len(pins) - 1
    relation = _relation(chain, members, coupled) if coupled and single else None
    relations = () if relation is None else (relation,)
    curve = tuple(coupled) if relation is None else ()
    leaf = Leaf(corank, dimension, pins, relations, free, curve, members, folded=True)
    kept = leaf.holds(members, ROUGH)
    return [replace(leaf, samples=leaf.pinned(members[kept]))] if kept.any() else []


def _pins(chain: ScrewChain, members: Array, corank: int, pinned: list[Angle]) -> tuple[Array, tuple[Pin, ...]]:
    """The pins, and members moved to them: first pins at exact values, then the others, which depend on them.

    If one value is off by δ in a flat direction, values in steep directions follow it.
    """
    exact = [pin for pin in (_middle(angle, members) for angle in pinned) if _is_exact(pin)]
    members = _settled(chain, _moved(members, exact), corank, [joint for pin in exact for joint in pin.angle.joints])
    known = {pin.angle: pin for pin in exact}
    pins = tuple(known.get(angle) or _middle(angle, members) for angle in pinned)
    return _moved(members, list(pins)), pins


def _middle(angle: Angle, members: Array) -> Pin:
    """A pin at the median of an angle's values, or at an exact value near it."""
    values = angle.of(members)
    return Pin(angle, nice(angle, float(values[0] + np.median(angle.wrapped(values - values[0]))), ROUGH))


def _is_exact(pin: Pin) -> bool:
    return abs(float(pin.angle.wrapped(pin.value - nice(pin.angle, pin.value, np.inf)))) < EXACTLY


def _moved(values: Array, pins: list[Pin]) -> Array:
    return brought(values, [pin.angle for pin in pins], np.array([pin.value for pin in pins]))


def _settled(chain: ScrewChain, values: Array, corank: int, pinned: list[int]) -> Array:
    """Newton steps in the steep directions, with the `pinned` joints held."""
    for _ in range(NEWTON):
        at = Residual.at(chain, values, corank)
        A = at.derivative.copy()
        A[..., pinned] = 0.0
        found = svd(A)
        steep = found.s > STEEP * at.scale[:, None]
        gain = np.where(steep, 1.0, 0.0) / np.where(steep, found.s, 1.0)
        values = values - np.einsum("nkj,nk,nik,ni->nj", found.Vt, gain, found.U, at.vector)
    return np.asarray(values)


def _relation(chain: ScrewChain, members: Array, coupled: list[int]) -> Relation | None:
    """A short relation of all of a few joints."""
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
