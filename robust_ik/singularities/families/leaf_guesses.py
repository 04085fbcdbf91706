"""Guesses leaves that no point led to, from those found: other combinations of values, mirrored values.

A guess is cheap to test, while a small basin of attraction may need thousands of starts. Every guess is tested.
Arrays only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from robust_ik.singularities.conditions.angle_sums import Angle, brought
from robust_ik.singularities.families.coupled_joints import coupled_leaves
from robust_ik.singularities.families.leaf import Leaf, is_singular, nice, sound_each
from robust_ik.singularities.families.leaf_merging import Values, joined, values_of
from robust_ik.singularities.find.tangent_walk import polish, readable_at
from robust_ik.singularities.geometry.screw_chain import ScrewChain

MOST_COMBINATIONS = 1024
"""Most combinations of the values of all angles that are tried."""
TRIALS = 2
"""Random members of a guess that must be singular before it is verified."""
PROJECTED = 60
"""Samples of a similar leaf that are projected if joints are coupled."""

Options = tuple[Values, ...]


def completed(chain: ScrewChain, leaves: Sequence[Leaf], rng: np.random.Generator) -> list[Leaf]:
    """The leaves of one corank, with further ones of the same angles and other values that pass the tests."""
    by_form: dict[tuple[object, ...], list[Leaf]] = {}
    for leaf in leaves:
        by_form.setdefault(leaf.shape, []).append(leaf)
    added: list[Leaf] = []
    for alike in by_form.values():
        guesses = list(dict.fromkeys(_guesses(alike)))
        if alike[0].relations or alike[0].curve:
            found = [leaf for guess in _with_values(alike, guesses) for leaf in _projected(chain, guess, rng)]
        else:
            found = _with_values(alike, _tried(chain, alike[0], guesses, rng))
            found = [replace(leaf, samples=leaf.filled(chain, rng)) for leaf in found]
        added += [leaf for leaf, good in zip(found, sound_each(chain, found, rng)) if good]
    return joined([*leaves, *added])


def _guesses(alike: Sequence[Leaf]) -> Iterator[Values]:
    """Values for the angles of leaves of one form that none of them has."""
    known = {values_of(leaf) for leaf in alike}
    for options in _options(alike):
        if math.prod(len(each) for each in options) <= MOST_COMBINATIONS:
            yield from (values for values in product(*options) if _rounded(values) not in known)


def _options(alike: Sequence[Leaf]) -> Iterator[Options]:
    """For each angle all values found; for leaves of pinned angles only, also those of each leaf mirrored."""
    exact = [{values_of(leaf)[i]: leaf.pins[i].value for leaf in alike} for i in range(len(alike[0].pins))]
    yield tuple(tuple(each[key] for key in sorted(each)) for each in exact)
    if not alike[0].relations and not alike[0].curve:
        mirrored = (tuple(_mirrored(pin.angle, pin.value) for pin in leaf.pins) for leaf in alike)
        yield from {tuple(_rounded(each) for each in options): options for options in mirrored}.values()


def _mirrored(angle: Angle, value: float) -> Values:
    """A value and those that a symmetric arm would also have, each once, ascending."""
    others = (value, -value, np.pi + value, np.pi - value) if angle.circular else (value, -value)
    return tuple(value for _, value in sorted({round(v, 6) + 0.0: v for v in (nice(angle, o) for o in others)}.items()))


def _rounded(values: Values) -> Values:
    return tuple(round(value, 6) + 0.0 for value in values)


def _tried(chain: ScrewChain, like: Leaf, guesses: Sequence[Values], rng: np.random.Generator) -> list[Values]:
    """The guesses at which a few random members are singular."""
    if not guesses:
        return []
    members = like.filled(chain, rng, TRIALS * len(guesses))
    members = brought(members, [pin.angle for pin in like.pins], np.repeat(np.array(guesses), TRIALS, axis=0))
    singular = is_singular(chain, members, like.corank).reshape(len(guesses), TRIALS).all(axis=1)
    return [guesses[int(place)] for place in np.flatnonzero(singular)]


def _with_values(alike: Sequence[Leaf], guesses: Sequence[Values]) -> list[Leaf]:
    """Leaves with other values, each made from the one that shares the most of them."""
    table, found = np.array([values_of(leaf) for leaf in alike]), []
    for values in guesses:
        like = alike[int(np.argmax((table == np.array(_rounded(values))).sum(axis=1)))]
        pins = tuple(replace(pin, value=value) for pin, value in zip(like.pins, values))
        found.append(replace(like, pins=pins))
    return found


def _projected(chain: ScrewChain, guess: Leaf, rng: np.random.Generator) -> list[Leaf]:
    """Leaves with given pins and coupled joints, by projecting the samples of a similar one."""
    coupled = {joint for relation in guess.relations for joint in relation.joints} | set(guess.curve)
    open_ = replace(guess, relations=(), curve=tuple(sorted(coupled)))
    ends = polish(chain, open_.pinned(guess.samples[:PROJECTED]), guess.corank)
    clear, dimensions = readable_at(ends.residual)
    values = ends.values[open_.holds(ends.values) & clear & (dimensions == guess.dimension)]
    return coupled_leaves(chain, replace(open_, samples=values), rng) if len(values) else []
