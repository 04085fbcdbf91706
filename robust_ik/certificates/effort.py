"""Effort of a proof, counted in steps, so that it is the same on every machine."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

SEVEN = 7
"""Joints of most arms that have one joint more than the task needs."""


class TooLargeError(Exception):
    """A polynomial or a field is too large for the effort allowed."""


class OutOfStepsError(TooLargeError):
    """No steps are left."""

    text = "no steps are left"


@dataclass
class Effort:
    """Bounds on the sizes of polynomials and fields, and the steps that are left; a step is about ten microseconds.

    Attributes:
        terms: Most terms of a polynomial.
        degree: Largest degree of a number field over ℚ.
        bits: Most bits expected in the numbers of a norm, of a resultant, or after a root is adjoined.
        steps: Steps left.
        whole: Whether all cases are looked at though one of them stays open.
    """

    terms: int
    degree: int
    bits: float
    steps: float
    whole: bool = False

    @classmethod
    def quick(cls, joints: int) -> Effort:
        """At most about three seconds' work; two for arms of seven joints, whose search alone takes long enough."""
        return cls(terms=400, degree=16, bits=1_500, steps=150_000 if joints == SEVEN else 250_000)

    @classmethod
    def thorough(cls) -> Effort:
        """Unlimited work: the caller ends it."""
        return cls(terms=20_000, degree=16, bits=math.inf, steps=math.inf, whole=True)

    def spend(self, steps: float) -> None:
        """Subtracts steps that are about to be taken.

        Raises:
            OutOfStepsError: None are left.
        """
        self.steps -= steps
        if self.steps < 0:
            raise OutOfStepsError(OutOfStepsError.text)

    def check_terms(self, count: int, what: str) -> None:
        """Raises if a polynomial has too many terms.

        Raises:
            TooLargeError: It has.
        """
        if count > self.terms:
            raise TooLargeError(f"{what} of {count} terms")

    def check_bits(self, bits: float, what: str) -> None:
        """Raises if numbers would be too long.

        Raises:
            TooLargeError: They would be.
        """
        if bits > self.bits:
            raise TooLargeError(f"{what} with numbers of {bits} bits")


def height(coefficients: Iterable[Any]) -> int:
    """Bits of the longest numerator or denominator."""
    return max((int(value.height_bits()) for value in coefficients), default=0)
