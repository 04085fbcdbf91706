"""Checks of leaves: that they are singular, and that other cases lie inside them."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction
from typing import Any

from robust_ik.certificates.checker.expected_children import RefusedError, image, require
from robust_ik.certificates.checker.modular_arithmetic import UnluckyError, random_prime, random_root, rank
from robust_ik.certificates.checker.modular_kinematics import ModularReplay, Point, collect, evaluate, random_point
from robust_ik.certificates.checker.modular_rings import Ring
from robust_ik.certificates.checker.random_points import RandomPoint
from robust_ik.certificates.proof.case_tree import RATIONAL, Form, Node
from robust_ik.certificates.proof.counted_steps import spend
from robust_ik.certificates.proof.proof import Proof
from robust_ik.certificates.proof.proof_arm import Arm

TRIES = 200
"""Most attempts to find a point on a leaf: relations have a root modulo about two primes of three."""


def check_leaf(proof: Proof, node: Node, rng: random.Random) -> None:
    """Checks that the Jacobian has the corank at a random point of the leaf, over a random prime field."""
    assert proof.arm is not None
    _check_relations(node)
    bound = proof.arm.rank - proof.corank
    for _ in range(TRIES):
        prime = random_prime(rng)
        try:
            point = _point(proof, node, rng, prime)
            if point is None:
                continue
            matrix = ModularReplay(proof.arm, proof.link, Ring(prime, RATIONAL)).jacobian(point)
        except UnluckyError:
            continue
        require(rank(matrix, prime) <= bound, "a leaf that is not singular throughout")
        return
    raise RefusedError("no point of a leaf was found")


def _check_relations(node: Node) -> None:
    """Checks that each relation is solved for a free joint that the later relations do not involve."""
    solved: list[int] = []
    for index, joint in reversed(node.relations):
        require(index < len(node.state.generators), "there is no such generator")
        form = node.state.generators[index]
        require(joint in form.joints and joint not in node.state.pinned, "a relation is solved for no joint of its own")
        require(joint not in solved, "two relations are solved for the same joint")
        solved.append(joint)
    for place, (_, joint) in enumerate(node.relations):
        later = [node.state.generators[index] for index, _ in node.relations[place + 1 :]]
        require(all(joint not in form.joints for form in later), "relations that cannot be solved one after another")


def _point(proof: Proof, node: Node, rng: random.Random, prime: int) -> Point | None:
    """A point of the leaf modulo a prime, or None if the relations have no root there."""
    assert proof.arm is not None
    ring = Ring(prime, node.state.field)
    theta = random_root(ring.monic, prime, rng)
    if theta is None:
        return None
    ring = Ring(prime, (str(-theta), "1"))  # θ is now a number
    pinned = node.state.pinned
    require(all(joint < len(proof.arm.joints) for joint in pinned), "pins of no joint")
    point: Point = {j: random_point(j, proof.arm, rng, prime) for j in range(len(proof.arm.joints))}
    for pin in node.state.pins:
        point[pin.joint] = (ring.number(pin.x), ring.number(pin.y))
    for index, joint in reversed(node.relations):
        polynomial = collect(node.state.generators[index], joint, point, ring)
        root = random_root(polynomial, prime, rng)
        at_pi = root is None and polynomial[-1] % prime == 0 and joint not in proof.arm.sliding
        if root is None and not at_pi:
            return None
        point[joint] = (0, 1) if root is None else (1, root)
    return point


def check_inside(proof: Proof, node: Node, leaf: Node, rng: random.Random, prime: int) -> None:
    """Checks that a case lies inside a leaf: it has the leaf's pins, and its generators imply the leaf's relations.

    A relation follows if it is zero with the pins inserted, or if a generator divides it there: tested on a random
    line.
    """
    require(leaf.kind == "leaf", "a case lies inside what is no leaf")
    pins = node.state.pinned
    for pin in leaf.state.pins:
        mine = pins.get(pin.joint)
        require(mine is not None, "a case lies outside the leaf: a joint is not pinned")
        assert mine is not None
        moved = tuple(image(value, node.image, node.state.field) for value in (pin.x, pin.y))
        require((mine.x, mine.y) == moved, "a case lies outside the leaf: a joint is pinned elsewhere")
    root = image(leaf.state.field, node.image, node.state.field)
    require(not any(Fraction(value) for value in root), "θ of the leaf is no root of its polynomial")
    place = RandomPoint.random(proof, node.state, rng, prime)
    for index, _ in leaf.relations:
        form = leaf.state.generators[index]
        terms = tuple((powers, image(value, node.image, node.state.field)) for powers, value in form.terms)
        _check_follows(proof.arm, node, replace(form, terms=terms), place)


def _check_follows(arm: Arm | None, node: Node, form: Form, place: RandomPoint) -> None:
    assert arm is not None
    if place.value(form) % place.ring.prime == 0:
        return
    other = RandomPoint(place.ring, {j: _direction(arm, place, j) for j in place.point}, place.rng)
    line = _on_line(form, place, other, node)
    for generator in node.state.generators:
        divisor = _on_line(generator, place, other, node)
        if divisor and _divides(divisor, line, place.ring):
            return
    raise RefusedError("a relation of the leaf does not follow from the case's generators")


def _divides(divisor: list[Any], value: list[Any], ring: Ring) -> bool:
    """Whether one polynomial over the ring divides another."""
    rest, p, scale = list(value), ring.prime, ring.inverse(divisor[-1])
    spend(3 * len(rest) * len(divisor))
    while len(rest) >= len(divisor):
        ratio = rest.pop() * scale % p
        start = len(rest) + 1 - len(divisor)
        for i, a in enumerate(divisor[:-1]):
            rest[start + i] = (rest[start + i] - ratio * a) % p
    return all(a == 0 for a in rest)


def _direction(arm: Arm, place: RandomPoint, joint: int) -> tuple[int, int]:
    """Direction of a joint along a random line; a sliding joint stays at (1 : d)."""
    p, rng = place.ring.prime, place.rng
    return 0 if joint in arm.sliding else rng.randrange(p), rng.randrange(p)


def _on_line(form: Form, place: RandomPoint, other: RandomPoint, node: Node) -> list[Any]:
    """A form along a line with the pins fixed, by interpolation: coefficients, lowest first, none if it is zero."""
    p, free = place.ring.prime, [j for j in form.joints if j not in node.state.pinned]
    degree = sum(d for j, d in zip(form.joints, form.degrees, strict=True) if j in free)
    values = []
    for u in range(degree + 1):
        point: Point = dict(place.point)
        for j in free:
            (a, b), (c, d) = place.point[j], other.point[j]
            point[j] = ((a + u * c) % p, (b + u * d) % p)
        values.append(evaluate(form, point, place.ring))
    result = _interpolated(values, p)
    while result and result[-1] == 0:
        result.pop()
    return result


def _interpolated(values: list[Any], p: int) -> list[Any]:
    """The polynomial with these values at 0, 1, 2, … (Newton's divided differences)."""
    table = list(values)
    spend(4 * len(table) ** 2)
    for step in range(1, len(table)):
        scale = pow(step, -1, p)
        for i in range(len(table) - 1, step - 1, -1):
            table[i] = (table[i] - table[i - 1]) * scale % p
    result: list[Any] = [table[-1]]
    for i in range(len(table) - 2, -1, -1):
        result = [(a - i * b) % p for a, b in zip([0, *result], [*result, 0], strict=True)]
        result[0] = (result[0] + table[i]) % p
    return result
