"""Relation: a short trigonometric equation that couples a few joints on a stratum, fitted to points. Arrays only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import chain, product

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.kinematics.svd import svd
from robust_ik.singularities.conditions.angle_sums import Angle

DEGREES = (1, 2, 3, 4)
"""Degrees in half angles: 2 stands for 1, cos q, sin q; odd ones for functions that change sign after a full turn."""
MOST_TERMS = 32
"""Most products of a basis: with more, a relation is not short."""
SHORT, SHORT_ODD = 12, 6
"""Most terms of a short relation, and of one with half angles or higher degrees."""
FITS = 1e-8
"""Singular value of the fitted products, relative to the largest one, below which a relation fits."""
UNIQUE = 1e-5
"""The next singular value must be above this; else several relations fit, and a smaller basis is needed."""
EXACT, RESOLVED = 1e-14, 1e-9
"""If there is none, one that fits up to rounding is taken, and the next singular value must only be above RESOLVED:
points of a family that is nearly a point leave it small.
"""
ZERO_COEFFICIENT = 1e-7
"""Coefficients below this fraction of the largest one are rounding. Chosen: ten times what FITS lets pass."""
SMALLEST = 1e-4
"""Smallest coefficient of a relation that is not zero: points of a nearly degenerate family fit smaller ones."""
TRIMS = 3
"""Most fits, each without the outliers of the one before. Chosen: fewer leave some in, more take longer."""
OUTLIER = 30.0
"""Points whose residual is this many times the median lie at crossings of strata."""


@dataclass(frozen=True)
class Factor:
    """One function of one angle.

    Attributes:
        angle: The angle.
        kind: "cos", "sin" or "power".
        order: The factor in cos(order · angle), possibly a half, or the exponent.
    """

    angle: Angle
    kind: str
    order: float

    def of(self, values: Array) -> Array:
        """Its value at joint values (..., n), (...)."""
        x = self.angle.of(values)
        if self.kind == "power":
            return np.asarray(x**self.order)
        return np.asarray(np.cos(self.order * x) if self.kind == "cos" else np.sin(self.order * x))

    def slope(self, values: Array) -> Array:
        """Its derivative with respect to the angle at joint values (..., n), (...)."""
        x = self.angle.of(values)
        if self.kind == "power":
            return np.asarray(self.order * x ** (self.order - 1))
        return np.asarray(self.order * (-np.sin(self.order * x) if self.kind == "cos" else np.cos(self.order * x)))

    def __str__(self) -> str:
        if self.kind == "power":
            return str(self.angle) if self.order == 1 else f"({self.angle})^{self.order:g}"
        if self.order == 1:
            return f"{self.kind[0]}{self.angle.suffix}"
        shown = {0.5: "½", 1.5: "3/2 "}.get(self.order, f"{self.order:g}")
        angle = f"·({self.angle})" if len(self.angle.joints) > 1 else str(self.angle)
        return f"{self.kind}({shown}{angle})"


Term = tuple[Factor, ...]


@dataclass(frozen=True, eq=False)
class Relation:
    """Σ coefficient · product of factors = 0.

    Attributes:
        terms: Products; the empty one is 1.
        coefficients: (t,), the largest magnitude being 1 in the units in which it was fitted.
        residual: Largest magnitude of the sum at the points that it was fitted to.
        points: Number of these points.
    """

    terms: tuple[Term, ...]
    coefficients: Array
    residual: float
    points: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "coefficients", readonly(self.coefficients))

    @property
    def joints(self) -> tuple[int, ...]:
        """Every joint in it, ascending."""
        return tuple(sorted({joint for term in self.terms for factor in term for joint in factor.angle.joints}))

    @property
    def angles(self) -> tuple[Angle, ...]:
        """Every angle in it, ascending."""
        return tuple(sorted({factor.angle for term in self.terms for factor in term}))

    def measured_in(self, units: Array) -> Relation:
        """The same relation of joint values in other units.

        Args:
            units: The new unit of each value, in the present one, (n,).
        """
        return replace(self, coefficients=self.coefficients * [_size_of(term, units) for term in self.terms])

    def of(self, values: Array) -> Array:
        """The sum at joint values (..., n), zero if the relation holds, (...)."""
        return evaluate(self.terms, values) @ self.coefficients

    def slopes(self, values: Array) -> Array:
        """The derivatives of the sum with respect to the joint values, (..., n) → (..., n)."""
        factors = dict.fromkeys(chain.from_iterable(self.terms))
        of, slope = ({each: getattr(each, what)(values) for each in factors} for what in ("of", "slope"))
        result = np.zeros(values.shape)
        for term, coefficient in zip(self.terms, self.coefficients):
            for place, factor in enumerate(term):
                others = [of[each] for each in (*term[:place], *term[place + 1 :])]
                part = math.prod(others, start=coefficient * slope[factor])
                for joint, sign in zip(factor.angle.joints, factor.angle.signs):
                    result[..., joint] += sign * part
        return result


def _size_of(term: Term, units: Array) -> float:
    """By how much the powers in a product are smaller if values are in other units."""
    return float(math.prod(units[each.angle.joints[0]] ** each.order for each in term if each.kind == "power"))


Known = dict[Factor, Array]
"""Values of factors at the points that relations are fitted to."""


def evaluate(terms: Sequence[Term], values: Array, known: Known | None = None) -> Array:
    """The value of each product at joint values (..., n), (..., t).

    Args:
        terms: The products.
        values: The joint values.
        known: Values of factors there, to which those that are missing are added.
    """
    known = {} if known is None else known
    for factor in chain.from_iterable(terms):
        if factor not in known:
            known[factor] = factor.of(values)
    result = np.ones((len(terms), *values.shape[:-1]))
    for place, term in enumerate(terms):
        for factor in term:
            result[place] *= known[factor]
    return np.ascontiguousarray(np.moveaxis(result, 0, -1))


def simplest(
    choices: Sequence[Sequence[Angle]], values: Array, *, odd: bool = False, known: Known | None = None
) -> Relation | None:
    """The relation with the fewest terms, over sets of angles with the same condition; None if none is short.

    Args:
        choices: Sets of angles of which no subset is related.
        values: Points of one stratum, (N, n).
        odd: Whether to try half angles and higher degrees too, and points close together: of one component only.
        known: Values of factors at these points, kept from one call to the next.
    """
    known = {} if known is None else known
    plain, strict = (linear_bases, product_bases), (FITS, UNIQUE)
    stages = [(stage, strict) for stage in (*plain, *([other_bases] if odd else []))]
    for stage, limits in (*stages, *((stage, (EXACT, RESOLVED)) for stage in plain if odd)):
        fits = (_first_fit(stage(angles), values, limits, known) for angles in choices)
        most = SHORT_ODD if stage is other_bases else SHORT
        short = [each for each in fits if each is not None and len(each.terms) <= most]
        if short:
            return min(short, key=lambda relation: (len(relation.terms), _factors(relation)))
    return None


def _first_fit(
    bases: Sequence[tuple[Term, ...]], values: Array, limits: tuple[float, float], known: Known
) -> Relation | None:
    fitting = (_null_vector(terms, values, limits, known) for terms in bases if len(values) >= 2 * len(terms))
    return next((relation for relation in fitting if relation is not None), None)


def linear_bases(angles: Sequence[Angle]) -> list[tuple[Term, ...]]:
    """The basis 1 and the cosine and sine of each angle."""
    waves = [(factor,) for angle in angles for factor in _functions(angle, 2) if factor is not None]
    return [((), *waves)]


def product_bases(angles: Sequence[Angle]) -> list[tuple[Term, ...]]:
    """The basis of products of 1, cosine and sine of each angle."""
    return [_products(angles, (2,) * len(angles))] if 3 ** len(angles) <= MOST_TERMS else []


def other_bases(angles: Sequence[Angle]) -> list[tuple[Term, ...]]:
    """Bases of products of other degrees for each angle, small ones first; for single joints only."""
    return [_products(angles, each) for each in _degrees(len(angles)) if _natural(angles, each)]


@cache
def _degrees(count: int) -> tuple[tuple[int, ...], ...]:
    """Degrees for `count` angles with not too many products, small ones first."""
    every = sorted(product(DEGREES, repeat=count), key=lambda each: (_size(each), each))
    return tuple(each for each in every if _size(each) <= MOST_TERMS)


def _size(degrees: Sequence[int]) -> int:
    return math.prod(degree + 1 for degree in degrees)


def _products(angles: Sequence[Angle], degrees: Sequence[int]) -> tuple[Term, ...]:
    functions = [_functions(angle, degree) for angle, degree in zip(angles, degrees)]
    return tuple(tuple(factor for factor in term if factor is not None) for term in product(*functions))


def _natural(angles: Sequence[Angle], degrees: Sequence[int]) -> bool:
    """Whether degrees make sense: a length has no half powers; sums of parallel joints replace products."""
    return all(len(each.joints) == 1 and (each.circular or degree % 2 == 0) for each, degree in zip(angles, degrees))


def _functions(angle: Angle, degree: int) -> list[Factor | None]:
    if not angle.circular:
        return [None, *(Factor(angle, "power", float(p)) for p in range(1, degree // 2 + 1))]
    orders = np.arange(degree % 2, degree + 1, 2) / 2
    waves: list[Factor | None] = [Factor(angle, kind, float(o)) for o in orders if o > 0 for kind in ("cos", "sin")]
    return waves if degree % 2 else [None, *waves]


def _null_vector(terms: tuple[Term, ...], values: Array, limits: tuple[float, float], known: Known) -> Relation | None:
    """The only combination of products that vanishes at the points, without outliers; None if it is not unique."""
    products = evaluate(terms, values, known)
    kept = np.ones(len(values), dtype=bool)
    for _ in range(TRIMS):
        found = svd(products[kept])
        vector = found.Vt[-1]
        size = np.abs(products @ vector)
        limit = max(OUTLIER * float(np.median(size)), FITS)
        if kept.sum() < 2 * len(terms) or (size <= limit)[kept].all():
            break
        kept = size <= limit
    s = found.s / found.s[0]
    fits, unique = limits
    if s[-1] > fits or (len(s) > 1 and s[-2] < unique) or kept.sum() < 0.9 * len(values):
        return None
    vector = vector / vector[int(np.argmax(np.abs(vector)))]
    large = np.abs(vector) > ZERO_COEFFICIENT
    if np.abs(vector[large]).min() < SMALLEST:
        return None
    chosen = tuple(term for term, big in zip(terms, large) if big)
    residual = float(np.abs(products[kept][:, large] @ vector[large]).max())
    return Relation(chosen, vector[large], residual, int(kept.sum()))


def _factors(relation: Relation) -> int:
    """The number of functions in a relation; sums of joints count more."""
    return sum(1 + len(factor.angle.joints) for term in relation.terms for factor in term)
