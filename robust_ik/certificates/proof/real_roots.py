"""Real roots of polynomials in one variable: number and places, by Sturm's theorem. Fractions and integers only."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise

from robust_ik.certificates.proof.counted_steps import spend

Poly = list[Fraction]


def _poly(coefficients: tuple[str, ...] | list[Fraction]) -> Poly:
    return _trimmed([Fraction(value) for value in coefficients])


def _trimmed(f: Poly) -> Poly:
    while f and f[-1] == 0:
        f = f[:-1]
    return f


def _chain(f: Poly) -> list[list[int]]:
    """Sturm's sequence f, f′, −rem, …, each times a positive number, by subresultants, so that numbers stay integers.

    Source: Brown and Traub, On Euclid's algorithm and the theory of subresultants, 1971.
    """
    whole = _whole(f)
    _spend(whole)
    chain = [whole, [i * a for i, a in enumerate(whole)][1:]]
    size, steps = 1, [1]
    while chain[-1]:
        before, last = chain[-2:]
        steps.append(len(before) - len(last))
        factor = 1
        if len(chain) > 2:
            head = abs(before[-1])
            size = head ** steps[-2] // size ** (steps[-2] - 1)
            factor = head * size ** steps[-1]
        chain.append([-a // factor for a in _remainder(before, last)])
    return chain[:-1]


def _remainder(f: list[int], g: list[int]) -> list[int]:
    """The remainder of f by g, times |head of g| to the power of the number of steps."""
    head, sign = abs(g[-1]), 1 if g[-1] > 0 else -1
    for shift in range(len(f) - len(g), -1, -1):
        quotient = sign * f[-1]
        f = [head * a - (quotient * g[i - shift] if i >= shift else 0) for i, a in enumerate(f[:-1])]
    while f and f[-1] == 0:
        f = f[:-1]
    return f


def _spend(f: list[int]) -> None:
    """Counts the steps of the sequence: numbers grow to the degree times their length."""
    degree, bits = len(f), max(a.bit_length() for a in f)
    spend(degree**2 * (10 + (degree * bits / 60) ** 1.6))


def _whole(f: Poly) -> list[int]:
    scale = math.lcm(*(a.denominator for a in f))
    spend(scale.bit_length() / 10)
    return [a.numerator * (scale // a.denominator) for a in f]


def _sign(f: list[int], x: Fraction) -> int:
    """The sign of f(x), from its numerator, without division."""
    result, power = 0, 1
    for coefficient in reversed(f):
        result = result * x.numerator + coefficient * power
        power *= x.denominator
    return (result > 0) - (result < 0)


def _changes(signs: list[int]) -> int:
    signs = [sign for sign in signs if sign]
    return sum(a != b for a, b in pairwise(signs))


def _changes_at(chain: list[list[int]], x: Fraction) -> int:
    return _changes([_sign(f, x) for f in chain])


def _bound(f: Poly) -> Fraction:
    """Cauchy's bound: every root is smaller in magnitude."""
    return 1 + max(abs(a / f[-1]) for a in f)


def real_root_count(coefficients: tuple[str, ...] | list[Fraction]) -> int:
    """Number of different real roots of a non-zero polynomial, coefficients lowest first."""
    f = _poly(coefficients)
    chain, bound = _chain(f), _bound(f)
    return _changes_at(chain, -bound) - _changes_at(chain, bound)


def has_real_root(coefficients: tuple[str, ...] | list[Fraction]) -> bool:
    """Whether there is a real root."""
    return real_root_count(coefficients) > 0


def real_roots(coefficients: tuple[str, ...] | list[Fraction], width: Fraction = Fraction(1, 2**64)) -> list[Fraction]:
    """The different real roots of a non-zero polynomial, each to within `width`, ascending.

    Args:
        coefficients: Lowest first.
        width: Half the width of the interval that provably holds the root and no other.
    """
    f = _poly(coefficients)
    chain, bound = _chain(f), _bound(f)
    waiting, found = [(-bound, _changes_at(chain, -bound), bound, _changes_at(chain, bound))], []
    while waiting:
        low, before, high, after = waiting.pop()
        middle = (low + high) / 2
        if before - after == 1 and high - low <= width:  # this many roots are in (low, high]
            found.append(middle)
        elif before > after:
            between = _changes_at(chain, middle)
            waiting += [(low, before, middle, between), (middle, between, high, after)]
    return sorted(found)
