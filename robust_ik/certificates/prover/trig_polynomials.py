"""Polynomials in cosines and sines of joints and in lengths of slides, in a normal form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flint import Ordering, fmpq, fmpq_mpoly_ctx

from robust_ik.certificates.prover.number_fields import Field

Pins = Mapping[int, tuple[Any, Any]]
"""Joint index → (x, y) of a fixed joint, elements of a field: (cos q/2 : sin q/2), or (1, d) for a sliding joint."""


@dataclass(frozen=True)
class Trig:
    """ℚ(θ)[cᵢ, sᵢ] with sᵢ² = 1 − cᵢ²: variables s₁ … sₙ, c₁ … cₙ, z for θ.

    For a sliding joint sᵢ is its length dᵢ, which satisfies no equation, and cᵢ does not occur.

    Attributes:
        n: Number of joints.
        field: ℚ(θ).
        sliding: The prismatic joints.
    """

    n: int
    field: Field
    sliding: frozenset[int] = frozenset()

    @cached_property
    def context(self) -> Any:
        """The polynomial ring that represents the elements."""
        names = [f"s{i}" for i in range(self.n)] + [f"c{i}" for i in range(self.n)] + ["z"]
        return fmpq_mpoly_ctx.get(names, Ordering.lex)

    @cached_property
    def _relations(self) -> list[Any]:
        gens = self.context.gens()
        return [gens[i] ** 2 + gens[self.n + i] ** 2 - 1 for i in range(self.n)]

    @cached_property
    def _modulus(self) -> Any:
        return self.element(self.field.polynomial)

    def element(self, value: Any) -> Any:
        """An element of ℚ(θ) as a polynomial."""
        z = self.context.gens()[-1]
        result = self.context.constant(0)
        for coefficient in reversed(value.coeffs()):
            result = result * z + coefficient
        return result

    def constant(self, value: Any) -> Any:
        """A fraction as a polynomial."""
        return self.context.constant(fmpq(value.numerator, value.denominator))

    def reduce(self, value: Any) -> Any:
        """The normal form: no sᵢ², θ below the degree of its modulus."""
        degrees = value.degrees()
        if max(degrees[: self.n]) <= 1 and degrees[-1] < self.field.degree:
            return value
        for i, relation in enumerate(self._relations):
            if degrees[i] > 1 and i not in self.sliding:
                value = divmod(value, relation)[1]
        if value.degrees()[-1] >= self.field.degree:
            value = divmod(value, self._modulus)[1]
        return value

    def length(self, joint: int, pins: Pins) -> Any:
        """The position of a sliding joint: a variable, or a constant if it is pinned."""
        return self.element(pins[joint][1]) if joint in pins else self.context.gens()[joint]

    def angle(self, joint: int, pins: Pins) -> tuple[Any, Any]:
        """Cosine and sine of a joint: variables, or constants if it is pinned."""
        if joint not in pins:
            gens = self.context.gens()
            return gens[self.n + joint], gens[joint]
        x, y = pins[joint]
        scale = self.field.inverse(self.field.reduce(x * x + y * y))
        cosine, sine = (self.field.reduce(self.field.reduce(value) * scale) for value in (x * x - y * y, 2 * x * y))
        return self.element(cosine), self.element(sine)
