"""Basis: products of functions of a few angles, in which a relation between them may be written. Arrays only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np

from robust_ik.checks import Array
from robust_ik.singularities.conditions.angle_sums import Angle
from robust_ik.singularities.conditions.trig_relations import Factor, Term

DEGREES = (1, 2, 3, 4)
"""Degrees in half angles: 2 stands for 1, cos q, sin q; odd ones for functions that change sign after a full turn."""
MOST_TERMS = 32
"""Most products of a basis: with more, a relation is not short."""

Part = tuple[Angle, int]
"""An angle and the degree of its functions."""
Known = dict[Part, Array]
"""Values of functions at the points that relations are fitted to, (N, functions)."""


@dataclass(frozen=True)
class Basis:
    """The terms that a relation may have.

    Attributes:
        parts: Each angle, and the degree of its functions.
        mixed: Whether functions of different angles are multiplied; else they stand beside each other.
    """

    parts: tuple[Part, ...]
    mixed: bool = True

    def __len__(self) -> int:
        sizes = [_count(angle, degree) for angle, degree in self.parts]
        return math.prod(sizes) if self.mixed else 1 + sum(size - 1 for size in sizes)

    @property
    def terms(self) -> tuple[Term, ...]:
        """The products."""
        functions = [_functions(angle, degree) for angle, degree in self.parts]
        if not self.mixed:
            return ((), *((factor,) for each in functions for factor in each if factor is not None))
        return tuple(tuple(factor for factor in term if factor is not None) for term in product(*functions))

    def at(self, values: Array, known: Known) -> Array:
        """The value of each product at joint values (N, n), as `evaluate` has it, (N, t).

        Args:
            values: The joint values.
            known: Values of functions there, to which those that are missing are added.
        """
        for part in self.parts:
            if part not in known:
                known[part] = _at(_functions(*part), values)
        first, *others = (known[part] for part in self.parts)
        if not self.mixed:
            return np.concatenate([first, *(each[:, 1:] for each in others)], axis=1)
        for each in others:
            first = (first[:, :, None] * each[:, None]).reshape(len(values), -1)
        return first


def linear_bases(angles: Sequence[Angle]) -> list[Basis]:
    """The basis 1 and the cosine and sine of each angle."""
    return [Basis(tuple((angle, 2) for angle in angles), mixed=False)]


def product_bases(angles: Sequence[Angle]) -> list[Basis]:
    """The basis of products of 1, cosine and sine of each angle."""
    return [Basis(tuple((angle, 2) for angle in angles))] if 3 ** len(angles) <= MOST_TERMS else []


def fewest_terms(angles: int, *, odd: bool) -> int:
    """Fewest terms of a relation between so many angles: where no products fit in a basis, each angle has its own.

    Args:
        angles: Their number.
        odd: Whether `other_bases` are tried, too.
    """
    return 1 if odd or 3**angles <= MOST_TERMS else angles


def other_bases(angles: Sequence[Angle]) -> list[Basis]:
    """Bases of products of other degrees for each angle, small ones first; for single joints only."""
    return [Basis(tuple(zip(angles, each))) for each in _degrees(len(angles)) if _natural(angles, each)]


@cache
def _degrees(count: int) -> tuple[tuple[int, ...], ...]:
    """Degrees for `count` angles with not too many products, small ones first."""
    every = sorted(product(DEGREES, repeat=count), key=lambda each: (_size(each), each))
    return tuple(each for each in every if _size(each) <= MOST_TERMS)


def _size(degrees: Sequence[int]) -> int:
    return math.prod(degree + 1 for degree in degrees)


def _natural(angles: Sequence[Angle], degrees: Sequence[int]) -> bool:
    """Whether degrees make sense: a length has no half powers; sums of parallel joints replace products."""
    return all(len(each.joints) == 1 and (each.circular or degree % 2 == 0) for each, degree in zip(angles, degrees))


def _functions(angle: Angle, degree: int) -> list[Factor | None]:
    """The functions of an angle, None for 1."""
    if not angle.circular:
        return [None, *(Factor(angle, "power", float(p)) for p in range(1, degree // 2 + 1))]
    orders = np.arange(degree % 2, degree + 1, 2) / 2
    waves: list[Factor | None] = [Factor(angle, kind, float(o)) for o in orders if o > 0 for kind in ("cos", "sin")]
    return waves if degree % 2 else [None, *waves]


def _count(angle: Angle, degree: int) -> int:
    """How many they are."""
    return degree + 1 if angle.circular else 1 + degree // 2


def _at(functions: Sequence[Factor | None], values: Array) -> Array:
    """Functions of an angle at joint values (N, n), (N, functions)."""
    return np.stack([np.ones(len(values)) if each is None else each.of(values) for each in functions], axis=1)
