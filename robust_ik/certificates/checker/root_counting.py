"""Counts real roots by Descartes' rule of signs and bisection: the checker's own count, beside `proof.real_roots`.

Of a polynomial without repeated roots, an interval is halved until its transformed polynomial has no change of sign,
and the interval no root, or one, and one root. That ends by the theorem of the two circles. Source: Collins and
Akritas, Polynomial real root isolation using Descartes' rule of signs, 1976. Integers only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from robust_ik.certificates.proof.counted_steps import spend

PRIME = 2**61 - 1
"""A prime modulo which repeated roots are looked for first."""


def count_real_roots(coefficients: Sequence[str | Fraction]) -> int:
    """Number of different real roots of a polynomial that is not zero, coefficients lowest first."""
    values = [Fraction(value) for value in coefficients]
    scale = math.lcm(*(value.denominator for value in values))
    spend(len(values) * (5 + scale.bit_length() / 60))
    f = _reduced([int(value * scale) for value in values])
    if not f:
        raise ValueError("a polynomial that is zero has any number of roots")
    zero = f[0] == 0
    while f[0] == 0:
        f = f[1:]
    f = _without_repetitions(f)
    mirrored = [-a if i % 2 else a for i, a in enumerate(f)]
    return zero + _positive_roots(f) + _positive_roots(mirrored)


def _positive_roots(f: list[int]) -> int:
    """Number of roots above 0 of a polynomial without repeated ones, and not with 0 among them."""
    count, waiting = 0, [_onto_unit_interval(f)]
    while waiting:
        g = waiting.pop()
        changes = _changes(_shifted(g[::-1]))
        if changes <= 1:
            count += changes
            continue
        degree = len(g) - 1
        left = [a << (degree - i) for i, a in enumerate(g)]
        right = _shifted(left)
        if right[0] == 0:  # a root in the middle
            count, right = count + 1, right[1:]
        waiting += [_reduced(left), _reduced(right)]
    return count


def _onto_unit_interval(f: list[int]) -> list[int]:
    """f(2ᵏ x), all of whose roots above 0 are below 1: by Cauchy's bound of the roots of f."""
    bits = max(a.bit_length() for a in f) - abs(f[-1]).bit_length() + 2
    return [a << (bits * i) for i, a in enumerate(f)]


def _shifted(f: list[int]) -> list[int]:
    """f(x + 1), by Horner's rule."""
    result, bits = list(f), max(a.bit_length() for a in f)
    spend(len(f) ** 2 * (0.5 + bits / 5000))
    for begin in range(len(f) - 1):
        for i in range(len(f) - 2, begin - 1, -1):
            result[i] += result[i + 1]
    return result


def _changes(f: list[int]) -> int:
    """How often the sign changes from one coefficient that is not zero to the next."""
    signs = [a > 0 for a in f if a]
    return sum(one != other for one, other in pairwise(signs))


def _reduced(f: list[int]) -> list[int]:
    """Without zeros at the top, and without a common divisor."""
    while f and f[-1] == 0:
        f = f[:-1]
    divisor = math.gcd(*f)
    return [a // divisor for a in f] if divisor > 1 else f


def _without_repetitions(f: list[int]) -> list[int]:
    """A polynomial with the same roots, each once."""
    slope = [i * a for i, a in enumerate(f)][1:]
    if _coprime_modulo(f, slope):
        return f
    common, rest = f, slope
    while rest:
        common, rest = rest, _reduced(_remainder(common, rest))
    return f if len(common) == 1 else _quotient(f, common)


def _coprime_modulo(f: list[int], g: list[int]) -> bool:
    """True if f and g have no common root modulo PRIME, and so none at all."""
    spend(len(f) ** 2)
    a, b = ([value % PRIME for value in each] for each in (f, g))
    if not b or not a[-1] or not b[-1]:
        return not b and len(f) == 1
    while len(b) > 1:
        inverse = pow(b[-1], -1, PRIME)
        while len(a) >= len(b):
            factor = a[-1] * inverse % PRIME
            at = len(a) - len(b)
            a = [(value - factor * b[i - at]) % PRIME if i >= at else value for i, value in enumerate(a[:-1])]
            while a and a[-1] == 0:
                a.pop()
        a, b = b, a
    return bool(b)


def _remainder(f: list[int], g: list[int]) -> list[int]:
    """The remainder of f by g, times a number that is not zero."""
    bits = max(a.bit_length() for a in (*f, *g))
    while len(f) >= len(g):
        spend(len(f) * (1 + (bits / 60) ** 1.6))
        at, top = len(f) - len(g), f[-1]
        f = [g[-1] * a - (top * g[i - at] if i >= at else 0) for i, a in enumerate(f[:-1])]
        while f and f[-1] == 0:
            f = f[:-1]
        bits += abs(g[-1]).bit_length()
    return f


def _quotient(f: list[int], g: list[int]) -> list[int]:
    """The quotient f / g of a polynomial and a divisor of it, times a number that is not zero."""
    rest, result = [Fraction(a) for a in f], []
    spend(len(f) ** 2 * 10)
    for at in range(len(f) - len(g), -1, -1):
        factor = rest[at + len(g) - 1] / g[-1]
        result.append(factor)
        for i, a in enumerate(g):
            rest[at + i] -= factor * a
    scale = math.lcm(*(value.denominator for value in result))
    return _reduced([int(value * scale) for value in reversed(result)])
