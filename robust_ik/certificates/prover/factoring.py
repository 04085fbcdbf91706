"""Factors forms over ℚ, or over a number field as far as there are factors over ℚ.

Over ℚ(θ) the common divisor of the coefficients of all powers of θ is factored over ℚ; the rest is a relation, or its
norm is factored.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flint import fmpq_poly

from robust_ik.certificates.effort import height
from robust_ik.certificates.prover.half_angle_forms import HalfAngles, Homogeneous


@dataclass(frozen=True)
class Factored:
    """The factors of a form over ℚ(θ), or (norm) of its norm over ℚ: constant · Π factor^power."""

    constant: Any
    factors: tuple[tuple[Homogeneous, int], ...]
    norm: bool = False

    @cached_property
    def cost(self) -> tuple[int, int, int]:
        """The cost of branching on it: numbers of factors in several joints, of algebraic ones, of all."""
        several = sum(len(factor.joints) > 1 for factor, _ in self.factors)
        algebraic = sum(len(factor.joints) == 1 and max(factor.degrees) > 1 for factor, _ in self.factors)
        return several, algebraic, len(self.factors)


def factor(half: HalfAngles, value: Homogeneous) -> Factored:
    """The factors of a non-zero form.

    Raises:
        TooLargeError: It has too many terms.
    """
    key = ("factored", value.key, half.field.modulus)
    return half.memory.recall(key, half.effort, lambda: _factored(half, value))


def _factored(half: HalfAngles, value: Homogeneous) -> Factored:
    half.effort.check_terms(len(value.value), "a polynomial")
    half.effort.spend(10 + 2 * len(value.value))
    if half.field.is_rational:
        constant, factors = _over_rationals(half, value)
        return Factored(fmpq_poly([constant]), tuple(factors))
    return _over_field(half, value)


def _over_rationals(half: HalfAngles, value: Homogeneous) -> tuple[Any, list[tuple[Homogeneous, int]]]:
    constant, found = value.value.factor()
    actual = value.value.degrees()
    factors = []
    for i, degree in enumerate(value.degrees):
        if degree > actual[i] and i not in half.sliding:
            x = tuple(int(i == j) for j in range(half.n))
            factors.append((Homogeneous(half.context.constant(1), x), degree - actual[i]))
    factors += [(Homogeneous(factor, factor.degrees()[:-1]), power) for factor, power in found]
    return constant, factors


def _over_field(half: HalfAngles, value: Homogeneous) -> Factored:
    common = _content(half, value.value)
    rest = half.reduce(divmod(value.value, common)[0])
    inner = rest.degrees()[:-1]
    constant, factors = _over_rationals(half, Homogeneous(common, tuple(a - b for a, b in zip(value.degrees, inner))))
    if not any(inner):
        return Factored(_element(rest) * constant, tuple(factors))
    over = _norm(half, rest)
    several = [factor for factor, _ in over[1] if len(factor.joints) > 1]
    if len(several) == len(over[1]):
        relation = (Homogeneous(rest, inner), 1)
        return Factored(fmpq_poly([constant]), (*factors, relation))
    power = half.field.degree
    merged = _merged([*((f, m * power) for f, m in factors), *over[1]])
    return Factored(fmpq_poly([constant**power * over[0]]), tuple(merged), norm=True)


def _norm(half: HalfAngles, value: Any) -> tuple[Any, list[tuple[Homogeneous, int]]]:
    effort, degree = half.effort, half.field.degree
    effort.check_terms(len(value) * degree, "the parts of a norm")
    bits = degree * height(value.coeffs()) + degree * height(half.modulus.coeffs())
    effort.check_bits(bits, "a norm")
    effort.spend(len(value) * degree * (1 + bits // 256))
    norm = half.modulus.resultant(value, "z")
    effort.check_terms(len(norm), "a norm")
    degrees = tuple(half.field.degree * degree for degree in value.degrees()[:-1])
    return _over_rationals(half, Homogeneous(norm, degrees))


def _content(half: HalfAngles, value: Any) -> Any:
    """The greatest factor over ℚ: the common divisor of the coefficients of all powers of θ."""
    parts: dict[int, dict[tuple[int, ...], Any]] = {}
    for powers, coefficient in value.to_dict().items():
        parts.setdefault(powers[-1], {})[(*powers[:-1], 0)] = coefficient
    result = half.context.constant(0)
    for part in parts.values():
        result = result.gcd(half.context.from_dict(part))
    return result


def _element(value: Any) -> Any:
    terms = {powers[-1]: coefficient for powers, coefficient in value.to_dict().items()}
    return fmpq_poly([terms.get(i, 0) for i in range(max(terms) + 1)])


def _merged(factors: Iterable[tuple[Homogeneous, int]]) -> list[tuple[Homogeneous, int]]:
    found: dict[tuple[str, tuple[int, ...]], tuple[Homogeneous, int]] = {}
    for factor, power in factors:
        key = (str(factor.value), factor.degrees)
        found[key] = (factor, power + (found[key][1] if key in found else 0))
    return list(found.values())
