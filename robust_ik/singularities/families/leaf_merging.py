"""Merges leaves to rows: equal leaves are joined, values combined, signs of relations explained by pinned joints.

Arrays only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from robust_ik.checks import Array
from robust_ik.singularities.conditions.angle_sums import wrapped
from robust_ik.singularities.conditions.trig_relations import Factor, Relation
from robust_ik.singularities.families.leaf import Leaf

SAME = 1e-6
"""Values and coefficients that differ by less are equal."""
Values = tuple[float, ...]


def joined(leaves: Sequence[Leaf]) -> list[Leaf]:
    """The leaves without duplicates; the samples of equal ones are put together."""
    found: list[Leaf] = []
    places: dict[tuple[object, ...], list[int]] = {}
    tables: dict[tuple[object, ...], Array] = {}
    for leaf in leaves:
        key = (leaf.corank, *leaf.shape)
        alike, table = places.setdefault(key, []), tables.setdefault(key, np.empty((len(leaves), len(leaf.pins))))
        near = np.flatnonzero(_near(leaf, table[: len(alike)]))
        index = next((alike[place] for place in near if equal(found[alike[place]], leaf)), None)
        if index is None:
            table[len(alike)] = leaf.values
            alike.append(len(found))
            found.append(leaf)
        else:
            found[index] = replace(found[index], samples=np.concatenate([found[index].samples, leaf.samples]))
    return found


def _near(leaf: Leaf, values: Array) -> Array:
    """Which values (L, P) of leaves of the same angles are equal to those of a leaf, (L,)."""
    periods = np.array([pin.angle.period for pin in leaf.pins])
    return np.asarray(np.all(np.abs(wrapped(values - leaf.values, periods)) <= SAME, axis=1))


def equal(one: Leaf, other: Leaf) -> bool:
    """Whether two leaves have the same conditions; curves are equal if they have the same joints."""
    if one.corank != other.corank or one.shape != other.shape:
        return False
    if not _near(one, other.values[None])[0]:
        return False
    return all(same_coefficients(a, b) for a, b in zip(one.relations, other.relations))


def same_coefficients(a: Relation, b: Relation) -> bool:
    """Whether two relations with the same terms are equal: their coefficients up to a common sign."""
    return bool(min(np.abs(a.coefficients - sign * b.coefficients).max() for sign in (1, -1)) < SAME)


def rows(leaves: Sequence[Leaf]) -> list[list[Leaf]]:
    """Groups of leaves whose conditions differ in values only, and whose values are all combinations of some values.

    Args:
        leaves: Leaves of one corank, without duplicates.

    Returns:
        The groups; in each, pins have the same angles and relations the same terms; signs are functions of pinned
        angles.
    """
    found: list[list[Leaf]] = []
    remaining = list(leaves)
    while remaining:
        alike = [leaf for leaf in remaining if _one_form(remaining[0], leaf)]
        remaining = [leaf for leaf in remaining if all(leaf is not other for other in alike)]
        for signed in _with_one_relation(alike):
            found += _boxes(signed)
    return found


def _one_form(one: Leaf, other: Leaf) -> bool:
    """Whether two leaves have the same terms, with coefficients of the same magnitudes."""
    return one.shape == other.shape and all(
        np.abs(np.abs(a.coefficients) - np.abs(b.coefficients)).max() < SAME
        for a, b in zip(one.relations, other.relations)
    )


def _with_one_relation(leaves: list[Leaf]) -> list[list[Leaf]]:
    """Leaves with equal relations; if signs differ, terms are multiplied by cosines or sines of pinned angles."""
    for index in range(len(leaves[0].relations)):
        common = _signed(leaves, index)
        if common is None:
            return _by_relation(leaves)
        leaves = [_with_relation(leaf, index, common) for leaf in leaves]
    return [leaves]


def _with_relation(leaf: Leaf, index: int, common: Relation) -> Leaf:
    relations = list(leaf.relations)
    relations[index] = replace(common, residual=relations[index].residual, points=relations[index].points)
    return replace(leaf, relations=tuple(relations))


def _by_relation(leaves: list[Leaf]) -> list[list[Leaf]]:
    groups: list[list[Leaf]] = []
    for leaf in leaves:
        for group in groups:
            if all(same_coefficients(a, b) for a, b in zip(leaf.relations, group[0].relations)):
                group.append(leaf)
                break
        else:
            groups.append([leaf])
    return groups


def _signed(leaves: Sequence[Leaf], index: int) -> Relation | None:
    """One relation for all leaves, or None if no pinned angle explains the different signs."""
    first = leaves[0].relations[index]
    reference = int(np.argmax(np.abs(first.coefficients) > 1 - SAME))
    table = np.stack([each.relations[index].coefficients for each in leaves])
    signs = np.sign(table * table[:, reference : reference + 1])
    terms, coefficients = [], np.abs(table).mean(axis=0) * signs[0]
    for column, term in enumerate(first.terms):
        pattern = signs[:, column] * signs[0, column]
        if (pattern > 0).all():
            terms.append(term)
            continue
        function = _sign_function(leaves, pattern)
        if function is None:
            return None
        factor, sign = function
        terms.append((*term, factor))
        coefficients[column] *= sign
    return Relation(tuple(terms), coefficients, first.residual, first.points)


def _sign_function(leaves: Sequence[Leaf], pattern: Array) -> tuple[Factor, float] | None:
    """The cosine or sine of a pinned angle that equals ±pattern at every leaf, and the sign."""
    for position, pin in enumerate(leaves[0].pins):
        values = np.array([leaf.pins[position].value for leaf in leaves])
        for kind, function in (("cos", np.cos), ("sin", np.sin)):
            for sign in (1.0, -1.0):
                if pin.angle.circular and np.abs(sign * function(values) - pattern).max() < SAME:
                    return Factor(pin.angle, kind, 1.0), sign
    return None


def _boxes(leaves: list[Leaf]) -> list[list[Leaf]]:
    """Leaves in as few groups as possible whose values are all combinations of values of each angle."""
    table = {values_of(leaf): leaf for leaf in leaves}
    found = []
    while table:
        best = max((_box(start, table) for start in list(table)[:16]), key=_count)
        members = list(product(*best))
        found.append([table.pop(member) for member in members])
    return found


def _count(box: Sequence[Values]) -> int:
    return math.prod(len(values) for values in box)


def _box(start: Values, table: dict[Values, Leaf]) -> list[Values]:
    """A largest set of combinations around one, extended angle by angle."""
    box: list[Values] = [(value,) for value in start]
    for position in range(len(start)):
        for value in sorted({values[position] for values in table}):
            wider = [*box[:position], tuple(sorted({*box[position], value})), *box[position + 1 :]]
            if all(member in table for member in product(*wider)):
                box = wider
    return box


def values_of(leaf: Leaf) -> Values:
    """The pinned values, rounded so that equal ones are equal as floats."""
    return tuple(round(pin.value, 6) + 0.0 for pin in leaf.pins)
