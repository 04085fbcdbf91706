"""Converts trigonometric polynomials to forms in (x : y) = (cos q/2 : sin q/2), or (1 : d) for a sliding joint.

ℚ[c, s]/(c² + s² − 1) has no unique factors (s² = (1 − c)(1 + c)), polynomials in t = tan q/2 have. With the formal
degree 2d, d being the trigonometric degree in normal form, no factor 1 + t² appears and none is lost at q = π: the
formal degree minus the degree in t is the multiplicity of x. A length d has no infinity: t is d itself, and its formal
degree is the actual one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import field as dataclass_field
from functools import cached_property
from typing import Any

from flint import Ordering, fmpq_mpoly_ctx

from robust_ik.certificates.effort import Effort
from robust_ik.certificates.proof.case_tree import ExactPin, Form, State
from robust_ik.certificates.prover.number_fields import Field, poly
from robust_ik.certificates.prover.remembered import Memory


@dataclass(frozen=True, eq=False)
class Homogeneous:
    """A form over ℚ(θ).

    Attributes:
        value: Polynomial in t₁ … tₙ and z for θ.
        degrees: Formal degrees in the joints.
    """

    value: Any
    degrees: tuple[int, ...]

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """Joints it involves."""
        return tuple(i for i, degree in enumerate(self.degrees) if degree)

    @cached_property
    def key(self) -> tuple[str, tuple[int, ...]]:
        """What tells it from others: its text and its degrees."""
        return str(self.value), self.degrees


@dataclass(frozen=True)
class HalfAngles:
    """The polynomials in t₁ … tₙ over a field.

    Attributes:
        n: Number of joints.
        field: ℚ(θ).
        effort: The effort that is left.
        sliding: The prismatic joints.
        memory: Results of the case split so far.
    """

    n: int
    field: Field
    effort: Effort
    sliding: frozenset[int] = frozenset()
    memory: Memory = dataclass_field(default_factory=Memory, compare=False, repr=False)

    @cached_property
    def context(self) -> Any:
        """Variables t₁ … tₙ, z."""
        return fmpq_mpoly_ctx.get([f"t{i}" for i in range(self.n)] + ["z"], Ordering.lex)

    @cached_property
    def modulus(self) -> Any:
        """The minimal polynomial of θ, in z."""
        z = self.context.gens()[-1]
        return sum((z**i * value for i, value in enumerate(self.field.polynomial.coeffs())), start=z * 0)

    def reduce(self, value: Any) -> Any:
        """The polynomial with the degree in θ reduced below that of its modulus."""
        return divmod(value, self.modulus)[1] if value.degrees()[-1] >= self.field.degree else value

    def homogeneous(self, value: Any, degrees: Sequence[int]) -> Homogeneous:
        """A polynomial with its formal degrees; those of lengths are set to the actual degrees."""
        actual = value.degrees() if value else (0,) * (self.n + 1)
        return Homogeneous(value, tuple(int(actual[i] if i in self.sliding else d) for i, d in enumerate(degrees)))

    @cached_property
    def _circles(self) -> Any:
        """Variables sᵢ, cᵢ, wᵢ, z: w makes trigonometric polynomials homogeneous."""
        return fmpq_mpoly_ctx.get([f"{letter}{i}" for letter in "scw" for i in range(self.n)] + ["z"], Ordering.lex)

    @cached_property
    def _images(self) -> list[Any]:
        """The images of these variables in t, times 1 + t²."""
        *t, z = self.context.gens()
        one, slides = self.context.constant(1), [i in self.sliding for i in range(self.n)]
        images = [x if slide else 2 * x for x, slide in zip(t, slides)]
        images += [one if slide else 1 - x * x for x, slide in zip(t, slides)]
        return [*images, *(one if slide else 1 + x * x for x, slide in zip(t, slides)), z]

    # ------------------------------------------------------------------------------------------ to and from forms
    def of(self, value: Any) -> Homogeneous:
        """A trigonometric polynomial in normal form, as a form: value · Π (x² + y²)^d."""
        return self.memory.recall(("form", self.field.modulus, str(value)), self.effort, lambda: self._of(value))

    def _of(self, value: Any) -> Homogeneous:
        n, terms = self.n, value.to_dict()
        self.effort.spend(2 + len(terms))
        degrees = [max(powers[i] + powers[n + i] for powers in terms) for i in range(n)]
        spread = {
            (*powers[: 2 * n], *(degrees[i] - powers[i] - powers[n + i] for i in range(n)), powers[-1]): coefficient
            for powers, coefficient in terms.items()
        }
        result = self._circles.from_dict(spread).compose(*self._images, ctx=self.context)
        return self.homogeneous(self.reduce(result), [2 * degree for degree in degrees])

    def form(self, value: Homogeneous) -> Form:
        """The form as plain values, scaled to integers without common factor if it is rational."""
        joints, grouped = value.joints, dict[tuple[int, ...], dict[int, Any]]()
        for powers, coefficient in value.value.to_dict().items():
            grouped.setdefault(tuple(int(powers[i]) for i in joints), {})[int(powers[-1])] = coefficient
        terms = []
        for key in sorted(grouped):
            found = grouped[key]
            terms.append((key, tuple(str(found.get(i, 0)) for i in range(max(found) + 1))))
        return Form(joints, tuple(int(value.degrees[i]) for i in joints), tuple(terms))

    def parse(self, form: Form) -> Homogeneous:
        """The inverse of `form`."""
        return self.memory.recall(("parsed", form), self.effort, lambda: self._parse(form))

    def _parse(self, form: Form) -> Homogeneous:
        terms, degrees = {}, [0] * self.n
        for joint, degree in zip(form.joints, form.degrees):
            degrees[joint] = degree
        for powers, values in form.terms:
            key = [0] * (self.n + 1)
            for joint, power in zip(form.joints, powers):
                key[joint] = power
            for i, coefficient in enumerate(poly(values).coeffs()):
                if coefficient:
                    terms[(*key[:-1], i)] = coefficient
        return self.homogeneous(self.context.from_dict(terms), degrees)

    def restrict(self, value: Homogeneous, state: State) -> Homogeneous:
        """A form with the pins of a state inserted."""
        pins = tuple(pin for pin in state.pins if value.degrees[pin.joint])
        key = ("restricted", value.key, pins, self.field.modulus)
        return self.memory.recall(key, self.effort, lambda: self._restrict(value, pins))

    def _restrict(self, value: Homogeneous, pins: Sequence[ExactPin]) -> Homogeneous:
        result, degrees = value.value, list(value.degrees)
        for pin in pins:
            if not any(poly(pin.x).coeffs()):
                terms = {p: a for p, a in result.to_dict().items() if p[pin.joint] == degrees[pin.joint]}
                kept = {(*p[: pin.joint], 0, *p[pin.joint + 1 :]): a for p, a in terms.items()}
                result = self.context.from_dict(kept)
            else:
                images = list(self.context.gens())
                z = images[-1]
                images[pin.joint] = sum((z**i * a for i, a in enumerate(poly(pin.y).coeffs())), start=z * 0)
                result = self.reduce(result.compose(*images, ctx=self.context))
            degrees[pin.joint] = 0
        return self.homogeneous(result, degrees)
