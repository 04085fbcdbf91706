"""The rings 𝔽ₚ[θ]/(m), in which joints at algebraic angles have coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from robust_ik.certificates.checker.modular_arithmetic import (
    UnluckyError,
    determinant_of_numbers,
    divide,
    fraction,
    inverse,
    minus,
    times,
    trimmed,
)
from robust_ik.certificates.proof.case_tree import Coefficients
from robust_ik.certificates.proof.counted_steps import spend


class Element:
    """An element of 𝔽ₚ[θ]/(m) for m of degree at least 2; it can be combined with integers.

    Sums and multiples are not reduced modulo p: `%` does that, as for integers.
    """

    __slots__ = ("ring", "values")

    def __init__(self, ring: Ring, values: Sequence[int]) -> None:
        self.ring = ring
        self.values = values

    def __add__(self, other: Any) -> Element:
        if isinstance(other, int):
            return Element(self.ring, [self.values[0] + other, *self.values[1:]])
        return Element(self.ring, [a + b for a, b in zip(self.values, other.values, strict=True)])

    __radd__ = __add__

    def __neg__(self) -> Element:
        return Element(self.ring, [-a for a in self.values])

    def __sub__(self, other: Any) -> Element:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Element:
        return self.__neg__().__add__(other)

    def __mul__(self, other: Any) -> Element:
        if isinstance(other, int):
            return Element(self.ring, [a * other for a in self.values])
        spend(3 * len(self.values) ** 2)
        product = [0] * (2 * len(self.values) - 1)
        for i, a in enumerate(self.values):
            for j, b in enumerate(other.values):
                product[i + j] += a * b
        result: Element = self.ring.element(product)
        return result

    __rmul__ = __mul__

    def __mod__(self, prime: int) -> Element:
        return Element(self.ring, [a % prime for a in self.values])

    def __eq__(self, other: Any) -> bool:
        difference = self - other
        return not any(a % self.ring.prime for a in difference.values)

    def __hash__(self) -> int:
        return hash(tuple(a % self.ring.prime for a in self.values))


@dataclass(eq=False)
class Ring:
    """The ring 𝔽ₚ[θ]/(m); its elements are plain integers modulo p if m has degree 1.

    Attributes:
        prime: p.
        modulus: Coefficients of m, lowest first.
    """

    prime: int
    modulus: Coefficients
    monic: list[int] = field(init=False)
    _cache: dict[Coefficients, Any] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        values = [fraction(value, self.prime) for value in self.modulus]
        scale = inverse(values[-1], self.prime)
        self.monic = [value * scale % self.prime for value in values]
        spend(100)

    @property
    def degree(self) -> int:
        """Degree of m."""
        return len(self.monic) - 1

    def number(self, coefficients: Coefficients) -> Any:
        """The element given by a polynomial in θ; a plain integer if θ does not occur."""
        if coefficients not in self._cache:
            values = [fraction(value, self.prime) for value in coefficients]
            self._cache[coefficients] = values[0] if len(values) == 1 else self.element(values)
        return self._cache[coefficients]

    def element(self, values: list[int]) -> Any:
        """The element with these coefficients, of any number, reduced."""
        values, size = list(values), self.degree
        while len(values) > size:
            head = values.pop() % self.prime
            for i in range(size):
                values[len(values) - size + i] -= head * self.monic[i]
        values = [value % self.prime for value in values] + [0] * (size - len(values))
        return values[0] if size == 1 else Element(self, values)

    def _powers(self, value: Element) -> list[list[int]]:
        """The matrix of multiplication by an element."""
        rows = []
        for i in range(self.degree):
            rows.append(list((self.element([0] * i + [1]) * value % self.prime).values))
        return rows

    def norm(self, value: Any) -> int:
        """The product of the element's values at all roots of m."""
        if self.degree == 1:
            return int(value) % self.prime
        matrix = self._powers(value if isinstance(value, Element) else self.element([value]))
        return determinant_of_numbers(matrix, self.prime)

    def inverse(self, value: Any) -> Any:
        """1/value, for a value without a common root with m."""
        if isinstance(value, int):
            return inverse(value, self.prime)
        p = self.prime
        before, after = trimmed(self.monic, p), trimmed(value.values, p)
        weight, other = [0], [1]
        while after:
            quotient, rest = divide(before, after, p)
            before, after = after, rest
            weight, other = other, minus(weight, times(quotient, other), p)
        if len(before) != 1:
            raise UnluckyError("an element without inverse")
        scale = inverse(before[0], p)
        return self.element([a * scale for a in weight])
