"""Relations between joints, readable for people and programs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, reduce

import numpy as np

from robust_ik.certificates.proof.case_tree import RATIONAL, Form, State
from robust_ik.certificates.proof.field_elements import element_product
from robust_ik.certificates.proof.proof_arm import Arm
from robust_ik.checks import Array

Term = dict[tuple[tuple[int, int], ...], Fraction]
"""Powers of (c, s) for each joint → coefficient."""
SHORT = 12
"""Most terms of a relation that is printed in full."""


@dataclass(frozen=True, eq=False)
class JointRelation:
    """Σ coefficient Π cos(q/2)^(degree − power) sin(q/2)^power = 0; d^power for a sliding joint at length d.

    Attributes:
        joints: Indices of the joints.
        names: Their names.
        degrees: Degree in the half angle, or length, of each joint.
        powers: Power of sin(q/2), or of d, in each term, (terms, joints).
        coefficients: The terms' coefficients, (terms,), largest 1 in size.
        exact: The coefficients as fractions: integers without common factor; empty if they are algebraic.
        sliding: Whether each of the joints slides.
    """

    joints: tuple[int, ...]
    names: tuple[str, ...]
    degrees: tuple[int, ...]
    powers: tuple[tuple[int, ...], ...]
    coefficients: tuple[float, ...]
    exact: tuple[Fraction, ...] | None
    sliding: tuple[bool, ...]

    def value(self, values: Array) -> Array:
        """The left side at joint values, (..., n) rad or m → (...).

        Without sliding joints its magnitude is at most the sum of the coefficients' magnitudes.
        """
        q = np.asarray(values, dtype=float)[..., list(self.joints)]
        powers = np.array(self.powers, dtype=int).reshape(-1, len(self.joints))
        terms = np.reshape(self.coefficients, (-1, *[1] * (q.ndim - 1))) * np.ones(q.shape[:-1])
        for index, (degree, slides) in enumerate(zip(self.degrees, self.sliding, strict=True)):
            own = q[..., index]
            x, y = (np.ones_like(own), own) if slides else (np.cos(own / 2), np.sin(own / 2))
            table = np.stack([x ** (degree - power) * y**power for power in range(degree + 1)])
            terms *= table[powers[:, index]]
        return np.asarray(terms.sum(axis=0))

    @property
    def short(self) -> bool:
        """Whether it is short enough to print in full."""
        return len(self.terms) <= SHORT

    @cached_property
    def terms(self) -> tuple[tuple[str, float], ...]:
        """Terms as ("c2 d3", coefficient): c2 = cos q2, d3 a length; "cos(q2/2)" if an angle's degree is odd."""
        if any(degree % 2 and not slides for degree, slides in zip(self.degrees, self.sliding, strict=True)):
            return tuple((self._half_angles(p), c) for p, c in zip(self.powers, self.coefficients, strict=True))
        found = self._trigonometric()
        largest = max(map(abs, found.values()), default=1.0)
        return tuple((self._monomial(key), value / largest) for key, value in found.items())

    def __str__(self) -> str:
        """The relation as an equation; one on a sum or difference of two joints as its value in degrees."""
        return (
            self._sum() or " ".join(_signed(name, value, not i) for i, (name, value) in enumerate(self.terms)) + " = 0"
        )

    def _half_angles(self, powers: tuple[int, ...]) -> str:
        parts = []
        for joint, name, degree, power, slides in zip(
            self.joints, self.names, self.degrees, powers, self.sliding, strict=True
        ):
            both = [] if slides else [(f"cos({name}/2)", degree - power), (f"sin({name}/2)", power)]
            parts += [f"{f}{_exponent(e)}" for f, e in both or [(f"d{joint + 1}", power)] if e]
        return " ".join(parts)

    def _monomial(self, key: tuple[tuple[int, int], ...]) -> str:
        parts = []
        for joint, pair, slides in zip(self.joints, key, self.sliding, strict=True):
            letters = zip("d" if slides else "cs", pair, strict=False)
            parts += [f"{letter}{joint + 1}{_exponent(e)}" for letter, e in letters if e]
        return " ".join(parts)

    def _trigonometric(self) -> dict[tuple[tuple[int, int], ...], float]:
        """The terms in cosines and sines: x² = (1 + c)/2, y² = (1 − c)/2, xy = s/2."""
        exact = self.exact or tuple(Fraction(value) for value in self.coefficients)
        total: Term = {}
        for powers, coefficient in zip(self.powers, exact, strict=True):
            term: Term = {(): coefficient}
            for degree, power, slides in zip(self.degrees, powers, self.sliding, strict=True):
                factor = {(power, 0): Fraction(1)} if slides else _half_angle_monomial(degree, power)
                term = {(*a, b): u * v for a, u in term.items() for b, v in factor.items()}
            for key, value in term.items():
                total[key] = total.get(key, Fraction(0)) + value
        kept = {key: float(value) for key, value in total.items() if abs(value) > 1e-12 * max(map(abs, exact))}
        return dict(sorted(kept.items(), key=lambda item: (-sum(map(sum, item[0])), item[0][::-1])))

    def _sum(self) -> str:
        """The relation as a sum or difference of two joints; empty if it is none."""
        if self.degrees != (1, 1) or any(self.sliding):
            return ""
        at = dict(zip(self.powers, self.coefficients, strict=True))
        xx, xy, yx, yy = (at.get(key, 0.0) for key in ((0, 0), (0, 1), (1, 0), (1, 1)))
        for sign, straight, crossed in (("+", xx + yy, xy - yx), ("−", xx - yy, xy + yx)):
            if abs(straight) + abs(crossed) < 1e-12:
                angle = math.degrees(2 * math.atan2(-xx, yx))
                return f"{self.names[0]} {sign} {self.names[1]} = {shown(angle)}"
        return ""


def relation(form: Form, state: State, theta: float, arm: Arm) -> JointRelation:
    """A generator of a state with its pins inserted, at one real place of the field.

    Args:
        form: The generator.
        state: The state.
        theta: The value of θ there.
        arm: The arm that the joints are of.
    """
    found = _restricted(form, state)
    keys = [key for key in sorted(found) if any(found[key])]
    values = [float(sum(float(a) * theta**i for i, a in enumerate(found[key]))) for key in keys]
    exact = None
    if state.field == RATIONAL or all(not any(found[key][1:]) for key in keys):
        exact = _primitive([found[key][0] for key in keys])
    largest = max(map(abs, values))
    pinned = state.pinned
    free = [i for i, joint in enumerate(form.joints) if joint not in pinned]
    joints, degrees = tuple(form.joints[i] for i in free), tuple(form.degrees[i] for i in free)
    scaled = tuple(value / largest for value in values)
    names, sliding = tuple(arm.joints[j] for j in joints), tuple(j in arm.sliding for j in joints)
    return JointRelation(joints, names, degrees, tuple(keys), scaled, exact, sliding)


def _restricted(form: Form, state: State) -> dict[tuple[int, ...], list[Fraction]]:
    """Terms with the pins inserted, coefficients in the field."""
    pinned, result = state.pinned, dict[tuple[int, ...], list[Fraction]]()
    for powers, coefficient in form.terms:
        value = [Fraction(a) for a in coefficient]
        for joint, degree, power in zip(form.joints, form.degrees, powers, strict=True):
            if joint in pinned:
                pin = pinned[joint]
                for text in (pin.x,) * (degree - power) + (pin.y,) * power:
                    value = element_product(value, [Fraction(a) for a in text], state.field)
        key = tuple(power for joint, power in zip(form.joints, powers, strict=True) if joint not in pinned)
        old = result.get(key, [])
        size = max(len(old), len(value))
        both = [part + [Fraction(0)] * (size - len(part)) for part in (old, value)]
        result[key] = [a + b for a, b in zip(*both, strict=True)]
    return result


def _primitive(values: list[Fraction]) -> tuple[Fraction, ...]:
    """The values scaled to integers without common factor."""
    scale = Fraction(math.lcm(*(value.denominator for value in values)))
    common = reduce(math.gcd, (int(value * scale) for value in values))
    return tuple(value * scale / common for value in values)


def _half_angle_monomial(degree: int, power: int) -> dict[tuple[int, int], Fraction]:
    """cos(q/2)^(degree − power) sin(q/2)^power as a polynomial in c, s of q, for an even degree."""
    odd = power % 2
    plus, minus = (degree - power - odd) // 2, (power - odd) // 2
    row = [Fraction(1)]
    for sign in [1] * plus + [-1] * minus:
        row = [(a + sign * b) / 2 for a, b in zip([*row, Fraction(0)], [Fraction(0), *row], strict=True)]
    return {(i, odd): a / (2 if odd else 1) for i, a in enumerate(row) if a}


def _exponent(power: int) -> str:
    return "" if power == 1 else "".join("⁰¹²³⁴⁵⁶⁷⁸⁹"[int(digit)] for digit in str(power))


def _signed(name: str, value: float, first: bool) -> str:
    sign = ("−" if value < 0 else "") if first else ("− " if value < 0 else "+ ")
    size = f"{abs(value):.7g}"
    return sign + (name if size == "1" and name else f"{size} {name}".rstrip())


def shown(degrees: float) -> str:
    """An angle in degrees, in (−180, 180], without trailing zeros."""
    turned = degrees - 360 * math.ceil(degrees / 360 - 0.5)
    nearest = round(turned)
    return f"{nearest}°" if abs(turned - nearest) < 1e-9 else f"{turned:.6f}°".replace("-", "−")


def shown_length(metres: float) -> str:
    """A length in metres, to the nanometre, without trailing zeros."""
    digits = f"{round(metres, 9) + 0.0:.9f}".rstrip("0").rstrip(".")  # + 0.0: no negative zero
    return digits.replace("-", "−") + " m"
