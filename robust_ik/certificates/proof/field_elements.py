"""Elements of a number field ℚ[θ]/(m), as lists of coefficients, lowest first: exact, with every step counted."""

from __future__ import annotations

from fractions import Fraction

from robust_ik.certificates.proof.case_tree import Coefficients
from robust_ik.certificates.proof.counted_steps import spend


def element_product(a: list[Fraction], b: list[Fraction], field: Coefficients) -> list[Fraction]:
    """The product of two elements of a field."""
    product = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, u in enumerate(a):
        for j, v in enumerate(b):
            product[i + j] += u * v
    return reduced(product, [Fraction(value) for value in field])


def reduced(values: list[Fraction], modulus: list[Fraction]) -> list[Fraction]:
    """The remainder of a polynomial in θ modulo the field's polynomial."""
    values, size = list(values), len(modulus) - 1
    while len(values) > size:
        head = values.pop() / modulus[-1]
        spend(sum(30 + (bits(head) * bits(each) / 1e6) + bits(head) / 30 for each in modulus))
        for i in range(size):
            values[len(values) - size + i] -= head * modulus[i]
    return values or [Fraction(0)]


def bits(value: Fraction) -> int:
    """The length of a fraction in bits, numerator and denominator together."""
    return value.numerator.bit_length() + value.denominator.bit_length()
