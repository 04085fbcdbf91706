"""Finds how the joints of a leaf that are neither free nor pinned are coupled: constant sums, short relations, curves.

Arrays only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby, product

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.svd import singular_values
from robust_ik.singularities.conditions.angle_sums import Angle, candidates
from robust_ik.singularities.conditions.dependent_angles import INDEPENDENT, Circuit, circuit_groups, independent
from robust_ik.singularities.conditions.relation_bases import Known, fewest_terms
from robust_ik.singularities.conditions.relation_fitting import SHORT, simplest_each
from robust_ik.singularities.conditions.trig_relations import Relation
from robust_ik.singularities.families.leaf import Leaf, Pin, nice
from robust_ik.singularities.find.tangent_walk import tangents, walk
from robust_ik.singularities.geometry.screw_chain import ScrewChain

WALKERS, LONG_WALK = 12, 14
"""Number of walks that continue one, and their steps: they give points of one stratum if those of a group are mixed."""
MOST_POINTS = 250
"""Most samples that relations are fitted to.

Chosen: eight times the 32 terms that a relation may have (`MOST_TERMS`).
"""
PATH = 17
"""Samples on one walk: its start, and the 16 steps of `walk`."""
CONSTANT = 1e-6
"""Angles that change less along a walk are constant, rad or m: as joints are, `tangent_walk.STILL`."""
MOST_SPLITS = 8
"""Most components that samples are split into. Chosen: limits the work; the rest is read in a later round."""


def coupled_leaves(chain: ScrewChain, leaf: Leaf, rng: np.random.Generator) -> list[Leaf]:
    """Complete leaves from an incomplete one, whose samples begin with a walk along one component.

    There are several if it has points of several strata with the same free and pinned joints.
    """
    pins = tuple(Pin(pin.angle, nice(pin.angle, pin.value)) for pin in leaf.pins)
    values = leaf.samples[replace(leaf, pins=pins).holds(leaf.samples, 1e-4)]
    if len(values) == 0:
        return []
    leaf = replace(leaf, pins=pins, samples=values[:MOST_POINTS])
    if not leaf.curve:
        return [leaf]
    finished: list[Leaf] = []
    for _ in range(MOST_SPLITS):
        found = _first(chain, leaf, rng)
        finished.append(found)
        rest = leaf.samples[~found.holds(leaf.samples)]
        if len(rest) == 0:
            break
        leaf = replace(leaf, samples=np.concatenate([_walked(chain, rest[:1], leaf, PATH - 1, rng), rest]))
    return finished


def _walked(chain: ScrewChain, starts: Array, leaf: Leaf, steps: int, rng: np.random.Generator) -> Array:
    """All points of walks along the leaf."""
    dimensions = np.full(len(starts), leaf.dimension)
    return walk(chain, starts, leaf.corank, dimensions, rng, steps=steps).values.reshape(-1, chain.n)


def _first(chain: ScrewChain, leaf: Leaf, rng: np.random.Generator) -> Leaf:
    """The leaf of the component on which the samples begin."""
    path = leaf.samples[:PATH]
    P = tangents(chain, path, leaf.corank, np.full(len(path), leaf.dimension))
    groups = circuit_groups(candidates(chain, leaf.curve, path), P)
    codimension = chain.n - leaf.dimension - len(leaf.pins)
    still = _independent([(group, pin) for group in groups if (pin := _still(group, path)) is not None], chain.n)
    leaf = replace(leaf, pins=(*leaf.pins, *(pin for _, pin in still)))
    values = leaf.samples[leaf.holds(leaf.samples)]
    coupled = [group for group in groups if _still(group, path) is None]
    normals = [group[0].normals for group, _ in still]
    chosen = _conditions(coupled, values, normals, codimension)
    if any(relation is None for _, relation in chosen):
        longer = _walked(chain, path[:WALKERS], leaf, LONG_WALK, rng)
        chosen = _conditions(coupled, longer, normals, codimension, odd=True)
    relations = tuple(relation for _, relation in chosen if relation is not None)
    spoken = {joint for _, pin in still for joint in pin.angle.joints} | {j for r in relations for j in r.joints}
    unspoken = set(leaf.curve) - spoken
    open_joints = {joint for group, relation in chosen if relation is None for joint in group[0].joints}
    if len(still) + len(chosen) < codimension:
        open_joints |= unspoken or set(leaf.curve)
    free = tuple(sorted({*leaf.free, *(unspoken - open_joints)}))
    result = replace(leaf, relations=relations, free=free, curve=tuple(sorted(open_joints)))
    return replace(result, samples=values[result.holds(values)])


def _conditions(
    groups: list[list[Circuit]], values: Array, normals: list[Array], count: int, *, odd: bool = False
) -> list[tuple[list[Circuit], Relation | None]]:
    """The circuits with the shortest relations that, together with known normals, have the full codimension.

    Circuits come by size: larger ones are not looked at where none of them can have a shorter relation.
    """
    known: Known = {}
    fitted: list[tuple[list[Circuit], Relation | None]] = []
    chosen: list[tuple[list[Circuit], Relation | None]] = []
    for size, alike in groupby(groups, key=lambda group: len(group[0].angles)):
        if chosen and len(normals) + len(chosen) == count and _longest(chosen) <= fewest_terms(size, odd=odd):
            break
        same = list(alike)
        relations = simplest_each([[each.angles for each in group] for group in same], values, odd=odd, known=known)
        fitted += [(group, _own(group, relation)) for group, relation in zip(same, relations)]
        chosen = _shortest(fitted, normals, count)
    return chosen


def _shortest(
    fitted: Sequence[tuple[list[Circuit], Relation | None]], normals: Sequence[Array], count: int
) -> list[tuple[list[Circuit], Relation | None]]:
    """Those of independent circuits, short relations first, until there are as many normals as are wanted."""
    chosen, normals = [], list(normals)
    for group, relation in sorted(fitted, key=lambda pair: _length(*pair)):
        if len(normals) < count and independent([*normals, group[0].normals]):
            normals.append(group[0].normals)
            chosen.append((group, relation))
    return chosen


def _length(group: Sequence[Circuit], relation: Relation | None) -> tuple[int, int]:
    """A sort key: relations by their terms, then circuits without one by their joints."""
    return (len(group[0].joints), SHORT + 1) if relation is None else (0, len(relation.terms))


def _longest(chosen: Sequence[tuple[list[Circuit], Relation | None]]) -> float:
    """Terms of the longest relation; endless where one is missing."""
    return max(math.inf if relation is None else len(relation.terms) for _, relation in chosen)


def _own(group: Sequence[Circuit], relation: Relation | None) -> Relation | None:
    """The relation if it has all joints of some circuit, else None: it then belongs to a smaller circuit."""
    if relation is None or any(set(circuit.joints) <= set(relation.joints) for circuit in group):
        return relation
    return None


def _still(group: Sequence[Circuit], path: Array) -> Pin | None:
    """A sum or difference of the angles of a circuit that is constant along a walk."""
    return next((pin for each in group for option in _sums(each.angles) if (pin := _standing(option, path))), None)


def _independent(still: Sequence[tuple[list[Circuit], Pin]], n: int) -> list[tuple[list[Circuit], Pin]]:
    """Constant angles without those that are combinations of others."""
    kept: list[tuple[list[Circuit], Pin]] = []
    for group, pin in still:
        rows = np.stack([each.angle.row(n) for _, each in (*kept, (group, pin))])
        if singular_values(rows)[-1] > INDEPENDENT:
            kept.append((group, pin))
    return kept


def _sums(angles: Sequence[Angle]) -> list[Angle]:
    """Signed sums of angles that may be constant."""
    if len(angles) == 1:
        return [angles[0]]
    if any(len(angle.joints) > 1 or not angle.circular for angle in angles):
        return []
    joints = tuple(sorted(angle.joints[0] for angle in angles))
    return [Angle(joints, (1, *signs), angles[0].period) for signs in product((1, -1), repeat=len(joints) - 1)]


def _standing(angle: Angle, path: Array) -> Pin | None:
    value = angle.of(path)
    drift = angle.wrapped(value - value[0])
    if np.abs(drift).max() > CONSTANT:
        return None
    return Pin(angle, nice(angle, float(value[0] + np.median(drift))))
