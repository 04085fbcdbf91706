"""Tests whether a polynomial vanishes on the relations between joints."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

from flint import fmpq_poly

from robust_ik.certificates.prover.half_angle_forms import HalfAngles

ORDERS = 6
"""Most orders of solving the relations that are tried: three relations, `case_decision.MAX_RELATIONS`, have six."""


def divides(half: HalfAngles, divisor: Any, value: Any) -> bool:
    """Whether a polynomial is a multiple of another one, over the field."""
    if half.field.is_rational:
        return not divmod(value, divisor)[1]
    monic = half.reduce(divisor * _inverse(half, divisor))
    return not half.reduce(divmod(value, monic)[1])


def _inverse(half: HalfAngles, value: Any) -> Any:
    """1/(leading coefficient), an element of the field as a polynomial in θ."""
    head = max(tuple(powers[:-1]) for powers in value.to_dict())
    terms = {int(powers[-1]): a for powers, a in value.to_dict().items() if tuple(powers[:-1]) == head}
    element = half.field.inverse(fmpq_poly([terms.get(i, 0) for i in range(max(terms) + 1)]))
    z = half.context.gens()[-1]
    return sum((z**i * a for i, a in enumerate(element.coeffs())), start=z * 0)


def vanishes(half: HalfAngles, value: Any, relations: list[Any]) -> bool:
    """Whether a polynomial is zero at generic points of the relations.

    It is if it is a multiple of one of them, or if pseudo-division by them, each solved for a joint of its own, leaves
    0.
    """
    if not value or any(divides(half, relation, value) for relation in relations):
        return True
    for order in itertools.islice(triangular(relations), ORDERS) if len(relations) > 1 else ():
        result = value
        for relation, joint in order:
            result = _pseudo_remainder(half, result, relation, joint)
        if not result:
            return True
    return False


def triangular(relations: list[Any]) -> Iterator[list[tuple[Any, int]]]:
    """The orders in which each relation can be solved for a joint that the later relations do not involve."""
    if len(relations) > 4:
        return
    for order in itertools.permutations(relations):
        choices = []
        for place, relation in enumerate(order):
            later = order[place + 1 :]
            used = [i for i, d in enumerate(relation.degrees()[:-1]) if d]
            choices.append([i for i in used if not any(other.degrees()[i] for other in later)])
        for joints in itertools.product(*choices):
            if len(set(joints)) == len(joints):
                yield list(zip(order, joints))


def _pseudo_remainder(half: HalfAngles, value: Any, divisor: Any, joint: int) -> Any:
    """The remainder in one joint after multiplying by powers of the divisor's leading coefficient.

    A polynomial that is too large is returned as it is: not zero.
    """
    if value.degrees()[joint] < divisor.degrees()[joint] or len(value) > half.effort.terms:
        return value
    *others, leading = _by_power(half, divisor, joint)
    rest, degree = _by_power(half, value, joint), len(others)
    while len(rest) > degree and (count := sum(map(len, rest))) <= half.effort.terms:
        half.effort.spend(1 + count * len(divisor) // 32)
        head = rest.pop()
        rest = [leading * a for a in rest]
        for i, b in enumerate(others, start=len(rest) - degree):
            rest[i] -= head * b
        rest = [half.reduce(a) for a in rest]
        while rest and not rest[-1]:
            rest.pop()
    t = half.context.gens()[joint]
    return sum((a * t**i for i, a in enumerate(rest)), start=half.context.constant(0))


def _by_power(half: HalfAngles, value: Any, joint: int) -> list[Any]:
    """The coefficients of the powers of one joint's t, lowest first; none of zero."""
    t, found = half.context.gens()[joint], []
    while value:
        found.append(value.subs({f"t{joint}": 0}))
        value = (value - found[-1]) / t
    return found
