"""Number fields ℚ(θ) for joints at algebraic angles: arithmetic, and adjoining a further root.

An element is a polynomial in θ of degree below that of the modulus. ℚ itself is the field with modulus θ.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

from flint import Ordering, fmpq, fmpq_mpoly_ctx, fmpq_poly

from robust_ik.certificates.effort import Effort, TooLargeError, height
from robust_ik.certificates.proof.real_roots import has_real_root

Element = Any
"""An fmpq_poly in θ."""
KEPT = 10_000
"""Most polynomials that are kept instead of read again. Chosen: those of a proof of 500 cases; some 200 bytes each."""


@dataclass(frozen=True)
class Field:
    """ℚ(θ) with θ a root of an irreducible polynomial.

    Attributes:
        modulus: Coefficients of the minimal polynomial of θ, lowest first, as "3/2"; ("0", "1") for ℚ.
    """

    modulus: tuple[str, ...] = ("0", "1")

    @property
    def degree(self) -> int:
        """Degree over ℚ."""
        return len(self.modulus) - 1

    @property
    def is_rational(self) -> bool:
        """Whether this is ℚ."""
        return self.degree == 1

    @cached_property
    def polynomial(self) -> Any:
        """The modulus."""
        return poly(self.modulus)

    def reduce(self, value: Element) -> Element:
        """A polynomial in θ, reduced by the modulus."""
        return value % self.polynomial

    def inverse(self, value: Element) -> Element:
        """1/value of a non-zero element."""
        if self.is_rational and (number := self.reduce(value)):
            return fmpq_poly([1 / number[0]])
        common, factor, _ = value.xgcd(self.polynomial)
        if common.degree() != 0:
            raise ZeroDivisionError("not invertible: the modulus is not irreducible or the element is zero")
        return self.reduce(factor / common[0])


@dataclass(frozen=True)
class Component:
    """One component of ℚ(θ)[t] / minimal(t): a field that contains θ and a root t.

    Attributes:
        field: ℚ(ζ), ζ = θ + λ t.
        old: θ as an element of it.
        new: t as an element of it.
        real: Whether ζ has a real value.
    """

    field: Field
    old: Element
    new: Element
    real: bool


@lru_cache(maxsize=KEPT)
def poly(coefficients: tuple[str, ...]) -> Any:
    """Coefficients, lowest first, as "3/2" → fmpq_poly."""
    return fmpq_poly([fmpq(*map(int, text.split("/"))) for text in coefficients])


def coefficients(element: Element) -> tuple[str, ...]:
    """fmpq_poly → coefficients, lowest first, at least one."""
    return tuple(str(value) for value in element.coeffs()) or ("0",)


def adjoin(field: Field, minimal: Any, effort: Effort) -> tuple[int, list[Component]]:
    """The components of ℚ(θ)[t] / minimal(t).

    Args:
        field: ℚ(θ).
        minimal: An irreducible fmpq_poly over ℚ.
        effort: The effort that is left.

    Returns:
        λ of the primitive element ζ = θ + λ t, and the components; their degrees add up to the product of both degrees.

    Raises:
        TooLargeError: That product, or the numbers, are too large.
    """
    degree = field.degree * minimal.degree()
    if degree > effort.degree:
        raise TooLargeError(f"a field of degree {degree}")
    bits = field.degree * height(minimal.coeffs()) + minimal.degree() * height(field.polynomial.coeffs())
    effort.check_bits(2 * bits, "a field")  # its elements have longer numbers than its polynomial
    effort.spend((degree * (1 + bits // 64)) ** 2)
    if field.is_rational:
        monic = minimal / minimal[minimal.degree()]
        grown = Field(coefficients(monic))
        return 1, [Component(grown, fmpq_poly([0]), fmpq_poly([0, 1]), has_real_root(coefficients(monic)))]
    for multiple in range(1, 100):
        norm = _norm(field, minimal, multiple)
        _, factors = norm.factor()
        if all(power == 1 for _, power in factors):
            return multiple, list(_components(field, minimal, multiple, [factor for factor, _ in factors]))
    raise ArithmeticError("no primitive element found")


def _norm(field: Field, minimal: Any, multiple: int) -> Any:
    """Π (ζ − θᵢ − λ tⱼ) up to a constant, over all roots of both."""
    context = fmpq_mpoly_ctx.get(["w", "z"], Ordering.lex)
    w, z = context.gens()
    shifted = _at(minimal, (z - w) / multiple, context)
    resultant = _at(field.polynomial, w, context).resultant(shifted, "w")
    terms = {exponents[1]: value for exponents, value in resultant.to_dict().items()}
    return fmpq_poly([terms.get(i, 0) for i in range(max(terms) + 1)])


def _at(polynomial: Any, value: Any, context: Any) -> Any:
    result = context.constant(0)
    for coefficient in reversed(polynomial.coeffs()):
        result = result * value + coefficient
    return result


def _components(field: Field, minimal: Any, multiple: int, factors: list[Any]) -> Iterator[Component]:
    for factor in factors:
        grown = Field(coefficients(factor / factor[factor.degree()]))
        first = [fmpq_poly([value]) for value in field.polynomial.coeffs()]
        old = _common_root(grown, first, _shifted(grown, minimal, multiple))
        new = grown.reduce((fmpq_poly([0, 1]) - old) / multiple)
        yield Component(grown, old, new, has_real_root(grown.modulus))


def _shifted(field: Field, minimal: Any, multiple: int) -> list[Any]:
    """minimal((ζ − w)/λ) as coefficients in w over the field."""
    line = [fmpq_poly([0, 1]) / multiple, fmpq_poly([-1]) / multiple]
    result = [fmpq_poly([0])]
    for coefficient in reversed(minimal.coeffs()):
        result = _product(field, result, line)
        result[0] = result[0] + coefficient
    return result


def _product(field: Field, f: list[Any], g: list[Any]) -> list[Any]:
    result = [fmpq_poly([0])] * (len(f) + len(g) - 1)
    for i, a in enumerate(f):
        for j, b in enumerate(g):
            result[i + j] = field.reduce(result[i + j] + a * b)
    return result


def _common_root(field: Field, f: list[Any], g: list[Any]) -> Element:
    """The only common root of two polynomials over the field, by Euclid's algorithm."""
    f, g = _trimmed(f), _trimmed(g)
    while g:
        scale = field.inverse(g[-1])
        while len(f) >= len(g):
            quotient = field.reduce(f[-1] * scale)
            shift = len(f) - len(g)
            f = _trimmed([field.reduce(a - quotient * g[i - shift]) if i >= shift else a for i, a in enumerate(f)])
        f, g = g, f
    if len(f) != 2:
        raise ArithmeticError("the primitive element does not separate the roots")
    return field.reduce(-f[0] * field.inverse(f[1]))


def _trimmed(f: list[Any]) -> list[Any]:
    while f and f[-1].degree() < 0:
        f = f[:-1]
    return f
