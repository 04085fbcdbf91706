"""Numbers, matrices and polynomials modulo a large prime, as plain integers."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

from robust_ik.certificates.proof.counted_steps import spend

WITNESSES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37)
"""The twelve smallest primes: no composite below 3.18e23 passes with all of them (Sorenson and Webster 2017)."""


class UnluckyError(Exception):
    """A division by zero modulo this prime or at this point; another one will do, or the proof is wrong."""


def is_prime(number: int) -> bool:
    """True if a number is prime, by Miller and Rabin's test; exact below 3e23."""
    if number < 41 or any(number % witness == 0 for witness in WITNESSES):
        return number in (*WITNESSES,)
    odd, twos = number - 1, 0
    while odd % 2 == 0:
        odd, twos = odd // 2, twos + 1
    for witness in WITNESSES:
        power = pow(witness, odd, number)
        if power not in (1, number - 1) and not any(
            (power := power * power % number) == number - 1 for _ in range(twos)
        ):
            return False
    return True


def random_prime(rng: random.Random) -> int:
    """A prime of 61 bits."""
    while not is_prime(candidate := rng.randrange(2**60 + 1, 2**61, 2)):
        pass
    return candidate


def fraction(text: str, prime: int) -> int:
    """A fraction, given as text, modulo a prime."""
    spend(fraction_steps(text))
    return residue(text, prime)


def fraction_steps(text: str) -> float:
    """The steps that reading a fraction takes."""
    return 5 + (len(text) / 40) ** 2


def residue(text: str, prime: int) -> int:
    """`fraction` without counting its steps, for callers that count them."""
    above, _, below = text.partition("/")
    return (int(above) * inverse(int(below), prime) if below else int(above)) % prime


def inverse(number: int, prime: int) -> int:
    """1/number modulo a prime."""
    if number % prime == 0:
        raise UnluckyError("a number without inverse")
    return pow(number, -1, prime)


def determinant(matrix: Sequence[Sequence[Any]], prime: int) -> Any:
    """The determinant, by expansion over sets of columns: without division, so in any ring."""
    minors: dict[int, Any] = {0: 1}
    size = len(matrix)
    spend(10 * size * 2**size)
    for row in matrix:
        grown: dict[int, Any] = {}
        entries = [(column, 1 << column, entry) for column, entry in enumerate(row) if entry]
        for used, value in minors.items():
            for column, bit, entry in entries:
                if not used & bit:
                    term = entry * value
                    if (used >> column).bit_count() % 2:
                        term = -term
                    grown[used | bit] = grown[used | bit] + term if used | bit in grown else term
        minors = {used: value % prime for used, value in grown.items()}
    return minors.get((1 << size) - 1, 0)


def determinant_of_numbers(matrix: Sequence[Sequence[int]], prime: int) -> int:
    """The determinant of a square matrix of integers modulo a prime, by elimination."""
    rows, result = [[value % prime for value in row] for row in matrix], 1
    spend(len(rows) ** 3)
    for column in range(len(rows)):
        place = next((i for i in range(column, len(rows)) if rows[i][column]), None)
        if place is None:
            return 0
        if place != column:
            rows[column], rows[place], result = rows[place], rows[column], -result
        result = result * rows[column][column] % prime
        scale = inverse(rows[column][column], prime)
        for i in range(column + 1, len(rows)):
            ratio = rows[i][column] * scale % prime
            rows[i] = [(a - ratio * b) % prime for a, b in zip(rows[i], rows[column], strict=True)]
    return result % prime


def rank(matrix: Sequence[Sequence[int]], prime: int) -> int:
    """The rank of a matrix of integers modulo a prime."""
    rows, found = [list(row) for row in matrix], 0
    for column in range(len(rows[0])):
        place = next((i for i in range(found, len(rows)) if rows[i][column] % prime), None)
        if place is None:
            continue
        rows[found], rows[place] = rows[place], rows[found]
        scale = inverse(rows[found][column], prime)
        for i in range(found + 1, len(rows)):
            ratio = rows[i][column] * scale % prime
            rows[i] = [(a - ratio * b) % prime for a, b in zip(rows[i], rows[found], strict=True)]
        found += 1
    return found


def trimmed(f: Sequence[int], prime: int) -> list[int]:
    """Coefficients modulo the prime, without zeros at the end."""
    values = [a % prime for a in f]
    while values and not values[-1]:
        values.pop()
    return values


def times(f: list[int], g: list[int]) -> list[int]:
    """The product of two polynomials, not reduced."""
    spend(len(f) * len(g))
    product = [0] * (len(f) + len(g) - 1)
    for i, a in enumerate(f):
        for j, b in enumerate(g):
            product[i + j] += a * b
    return product


def minus(f: list[int], g: list[int], prime: int) -> list[int]:
    """The difference of two polynomials."""
    size = max(len(f), len(g))
    f, g = f + [0] * (size - len(f)), g + [0] * (size - len(g))
    return [(a - b) % prime for a, b in zip(f, g, strict=True)]


def divide(f: list[int], g: list[int], prime: int) -> tuple[list[int], list[int]]:
    """Quotient and remainder; g without zeros at the end."""
    f, scale, quotient = trimmed(f, prime), inverse(g[-1], prime), [0] * max(1, len(f) - len(g) + 1)
    spend(2 * len(f) * max(1, len(f) - len(g) + 1))
    while len(f) >= len(g):
        shift, ratio = len(f) - len(g), f[-1] * scale % prime
        quotient[shift] = ratio
        f = trimmed([a - ratio * g[i - shift] if i >= shift else a for i, a in enumerate(f)], prime)
    return quotient, f


def gcd(f: list[int], g: list[int], prime: int) -> list[int]:
    """The greatest common divisor of two polynomials."""
    f, g = trimmed(f, prime), trimmed(g, prime)
    while g:
        f, g = g, divide(f, g, prime)[1]
    return f


def product(factors: Sequence[list[int]], prime: int) -> list[int]:
    """The product of polynomials."""
    result = [1]
    for factor in factors:
        result = trimmed(times(result, factor), prime)
    return result


def random_root(f: list[int], prime: int, rng: random.Random) -> int | None:
    """A random root modulo the prime, all alike (Cantor and Zassenhaus); None if there is none."""
    f = trimmed(f, prime)
    if len(f) < 2:
        return None
    if len(f) > 2:
        f = gcd(minus(_power([0, 1], prime, f, prime), [0, 1], prime), f, prime)
    while len(f) > 2:
        power = _power([rng.randrange(prime), 1], (prime - 1) // 2, f, prime)
        part = gcd(minus(power, [1], prime), f, prime)
        if 1 < len(part) < len(f):
            f = part if rng.random() < 0.5 else divide(f, part, prime)[0]
    return None if len(f) < 2 else -f[0] * inverse(f[1], prime) % prime


def _power(base: list[int], exponent: int, modulus: list[int], prime: int) -> list[int]:
    result = [1]
    for bit in bin(exponent)[2:]:
        result = divide(times(result, result), modulus, prime)[1] or [0]
        if bit == "1":
            result = divide(times(result, base), modulus, prime)[1] or [0]
    return result
