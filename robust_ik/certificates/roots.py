"""Real roots of polynomials in one variable: how many, and where, by Sturm's theorem. Fractions only."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

Poly = list[Fraction]


def _poly(coefficients: tuple[str, ...] | list[Fraction]) -> Poly:
    return _trimmed([Fraction(value) for value in coefficients])


def _trimmed(f: Poly) -> Poly:
    while f and f[-1] == 0:
        f = f[:-1]
    return f


def _remainder(f: Poly, g: Poly) -> Poly:
    while len(f) >= len(g):
        quotient, shift = f[-1] / g[-1], len(f) - len(g)
        f = _trimmed([a - quotient * g[i - shift] if i >= shift else a for i, a in enumerate(f[:-1])])
    return f


def _chain(f: Poly) -> list[Poly]:
    """Sturm's sequence f, f′, −rem, ..."""
    chain = [f, _trimmed([i * a for i, a in enumerate(f)][1:])]
    while chain[-1]:
        chain.append([-a for a in _remainder(chain[-2], chain[-1])])
    return chain[:-1]


def _value(f: Poly, x: Fraction) -> Fraction:
    result = Fraction(0)
    for coefficient in reversed(f):
        result = result * x + coefficient
    return result


def _changes(signs: list[int]) -> int:
    signs = [sign for sign in signs if sign]
    return sum(a != b for a, b in pairwise(signs))


def _changes_at(chain: list[Poly], x: Fraction) -> int:
    values = [_value(f, x) for f in chain]
    return _changes([(value > 0) - (value < 0) for value in values])


def _bound(f: Poly) -> Fraction:
    """Cauchy's bound: every root is smaller in size."""
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
    """The different real roots of a non-zero polynomial, each to within `width`, rising.

    Args:
        coefficients: Lowest first.
        width: Half the width of the interval that provably holds the root and no other.
    """
    f = _poly(coefficients)
    chain, bound = _chain(f), _bound(f)
    waiting, found = [(-bound, bound)], []
    while waiting:
        low, high = waiting.pop()
        count = _changes_at(chain, low) - _changes_at(chain, high)  # roots in (low, high]
        middle = (low + high) / 2
        if count == 1 and high - low <= width:
            found.append(middle)
        elif count:
            waiting += [(low, middle), (middle, high)]
    return sorted(found)
