"""Relation: a short trigonometric equation that couples a few joints on a stratum. Arrays only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.singularities.conditions.angle_sums import Angle


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


def evaluate(terms: Sequence[Term], values: Array) -> Array:
    """The value of each product at joint values (..., n), (..., t)."""
    known = {factor: factor.of(values) for factor in dict.fromkeys(chain.from_iterable(terms))}
    result = np.ones((len(terms), *values.shape[:-1]))
    for place, term in enumerate(terms):
        for factor in term:
            result[place] *= known[factor]
    return np.ascontiguousarray(np.moveaxis(result, 0, -1))
