"""Random points of a case, and the value of its vanishing source there."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Any

from robust_ik.certificates.checker.expected_children import require, univariate
from robust_ik.certificates.checker.modular_arithmetic import (
    UnluckyError,
    determinant,
    gcd,
    inverse,
    product,
    trimmed,
)
from robust_ik.certificates.checker.modular_kinematics import ModularReplay, Point, collect, dot, evaluate, random_point
from robust_ik.certificates.checker.modular_rings import Element, Ring
from robust_ik.certificates.proof.case_tree import Form, FormFactor, Node, Source, State
from robust_ik.certificates.proof.proof import Proof


@dataclass(frozen=True, eq=False)
class RandomPoint:
    """A point of a state, in a ring.

    Attributes:
        ring: 𝔽ₚ[θ]/(m).
        point: (x, y) of every joint: the pins, and random numbers.
        rng: For further random numbers.
    """

    ring: Ring
    point: Point
    rng: random.Random

    @classmethod
    def random(cls, proof: Proof, state: State, rng: random.Random, prime: int) -> RandomPoint:
        """A random point at which the pins hold; the generators need not vanish there."""
        assert proof.arm is not None
        ring = Ring(prime, state.field)
        n, pinned = len(proof.arm.joints), state.pinned
        require(all(pin.joint < n for pin in state.pins) and len(pinned) == len(state.pins), "pins of no joint")
        point: Point = {}
        for joint in range(n):
            if joint in pinned:
                pin = pinned[joint]
                point[joint] = (ring.number(pin.x), ring.number(pin.y))
            else:
                point[joint] = random_point(joint, proof.arm, rng, prime)
        return cls(ring, point, rng)

    def value(self, form: Form) -> Any:
        """A form's value at the point."""
        require(all(joint in self.point for joint in form.joints), "a form of no joint")
        return evaluate(form, self.point, self.ring)

    def is_algebraic(self, form: Form) -> bool:
        """Whether some coefficient of the form is not rational."""
        return any(len(coefficient) > 1 for _, coefficient in form.terms)

    def check_components(self, factor: FormFactor) -> None:
        """Checks that the roots of the branches' polynomials are exactly all θ + λ t, each once."""
        ring, p = self.ring, self.ring.prime
        minimal = univariate(factor.form)
        require(minimal[-1], "a factor with a root at q = π has it left out")
        moduli = [Ring(p, branch.field).monic for branch in factor.branches]
        whole = product(moduli, p)
        require(len(whole) - 1 == ring.degree * (len(minimal) - 1), "the branches are not all roots")
        slope = trimmed([i * a for i, a in enumerate(whole)][1:], p)
        require(len(gcd(whole, slope, p)) == 1, "two branches meet")
        z, theta = self.rng.randrange(p), ring.element([0, 1])
        t = (z - theta) * inverse(factor.multiple, p)
        numbers = [ring.number((str(a),)) for a in minimal]
        value: Any = 0
        for number in reversed(numbers):
            value = (value * t + number) % p
        scale = pow(factor.multiple, len(minimal) - 1, p) * inverse(int(_whole(numbers[-1])), p) % p
        found = sum(a * pow(z, i, p) for i, a in enumerate(whole)) % p
        require(ring.norm(value) * pow(scale, ring.degree, p) % p == found, "the branches are not the factor's roots")


def _whole(value: Any) -> int:
    """A rational element as an integer modulo the prime."""
    return int(value.values[0]) if isinstance(value, Element) else int(value)


def source_value(place: RandomPoint, proof: Proof, node: Node) -> Any:
    """The value of the node's source, which must vanish, homogeneous by the degrees that the node states."""
    source, state = node.source, node.state
    assert source is not None
    if source.kind == "minor":
        return _minor(place, proof, node, source)
    require(0 <= source.first < len(state.generators), "there is no such generator")
    if source.kind == "generator":
        return place.value(state.generators[source.first])
    require(0 <= source.second < len(state.generators), "there is no such generator")
    require(source.joint not in state.pinned and source.joint in place.point, "a pinned joint cannot be eliminated")
    pair = (state.generators[source.first], state.generators[source.second])
    first, second = (collect(form, source.joint, place.point, place.ring) for form in pair)
    require(min(len(first), len(second)) > 1, "a relation does not involve the joint to be eliminated")
    return _resultant(first, second, place.ring.prime)


def _minor(place: RandomPoint, proof: Proof, node: Node, source: Source) -> Any:
    """A minor of the Jacobian, its rows combined by constants, times Π (x² + y²)^(d/2)."""
    assert proof.arm is not None
    arm, ring, p = proof.arm, place.ring, place.ring.prime
    size = arm.rank - proof.corank + 1
    require(len(source.columns) == len(set(source.columns)) == len(source.rows) == size, "a minor of another size")
    require(all(column < len(arm.joints) for column in source.columns), "a minor of no joint")
    require(all(len(row) == len(arm.rows) for row in source.rows), "weights of no row")
    matrix = ModularReplay(arm, proof.link, ring).jacobian(place.point)
    columns = list(zip(*matrix))
    weights = [[ring.number(weight) for weight in row] for row in source.rows]
    chosen = [[dot(row, columns[column]) % p for column in source.columns] for row in weights]
    value = determinant(chosen, p)
    for joint, degree in node.degrees:
        free = joint in place.point and joint not in node.state.pinned
        require(free and joint not in arm.sliding and degree % 2 == 0, "degrees of no joint that turns")
        x, y = place.point[joint]
        value = value * pow(x * x + y * y, degree // 2, p) % p
    return value


def _resultant(f: list[Any], g: list[Any], p: int) -> Any:
    """Sylvester's determinant of two polynomials, lowest coefficients first, by their formal degrees."""
    a, b = len(f) - 1, len(g) - 1
    if a + b > 14:
        raise UnluckyError("a resultant of too high a degree")
    rows = [[0] * i + f[::-1] + [0] * (b - 1 - i) for i in range(b)]
    rows += [[0] * i + g[::-1] + [0] * (a - 1 - i) for i in range(a)]
    return determinant(rows, p)
