"""Effort: how much work a proof may take, counted in steps, so that it is the same on every machine."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

SEVEN = 7
"""Joints of most arms that have one more than the task needs."""


class TooLargeError(Exception):
    """A polynomial or a field that is too large to be worked with in the effort there is."""


class OutOfStepsError(TooLargeError):
    """No steps are left."""


@dataclass
class Effort:
    """Bounds of what is worked on, and the steps that are left; a step is about ten microseconds' work.

    Attributes:
        terms: Most terms of a polynomial.
        degree: Largest degree of a number field over ℚ.
        bits: Most bits of a number that is to be expected from a norm, a resultant or a root that is adjoined.
        steps: What is left.
    """

    terms: int
    degree: int
    bits: float
    steps: float

    @classmethod
    def quick(cls, joints: int) -> Effort:
        """About three seconds' work at most, two for arms of seven joints, whose search takes long enough by itself."""
        return cls(terms=400, degree=16, bits=1_500, steps=150_000 if joints == SEVEN else 250_000)

    @classmethod
    def thorough(cls) -> Effort:
        """Work without end: the caller ends it."""
        return cls(terms=20_000, degree=16, bits=math.inf, steps=math.inf)

    def spend(self, steps: float) -> None:
        """Counts steps.

        Raises:
            OutOfStepsError: None are left.
        """
        self.steps -= steps
        if self.steps < 0:
            raise OutOfStepsError("no steps are left")

    def check_terms(self, count: int, what: str) -> None:
        """Refuses too many terms.

        Raises:
            TooLargeError: They are too many.
        """
        if count > self.terms:
            raise TooLargeError(f"{what} of {count} terms")

    def check_bits(self, bits: float, what: str) -> None:
        """Refuses numbers that would be too long.

        Raises:
            TooLargeError: They would be.
        """
        if bits > self.bits:
            raise TooLargeError(f"{what} with numbers of {bits} bits")


def height(coefficients: Iterable[Any]) -> int:
    """Bits of the longest numerator or denominator."""
    return max((int(value.height_bits()) for value in coefficients), default=0)
