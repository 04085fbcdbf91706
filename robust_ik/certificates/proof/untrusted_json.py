"""Reads values from JSON that is not trusted: a value of another type or size than allowed is refused."""

from __future__ import annotations

import json
import re
from typing import Any

from robust_ik.certificates.proof.case_tree import Coefficients
from robust_ik.errors import InputError

MAX_DIGITS = 2_000
"""Most digits of a numerator or denominator.

Chosen: below the 4,300 that Python's `int` reads; the xArm7's proofs have 45.
"""
MAX_DEGREE = 128
"""Largest number of a pair, such as a power: the same as for forms, `proof.MAX_DEGREE`."""
MAX_FIELD = 17
"""Most coefficients of a field's polynomial: a prover works in fields up to degree 16."""
MAX_TEXT = 400
"""Most characters of a name or a reason. Chosen: four times the longest in our proofs (87), a few lines on a screen."""
FRACTION = re.compile(rf"-?[0-9]{{1,{MAX_DIGITS}}}(/[1-9][0-9]{{0,{MAX_DIGITS - 1}}})?")


MOST_LISTS, MOST_VALUES = 2_000_000, 6_000_000
"""Most brackets and commas of a text; a proof of 500 cases has 50,000 and 100,000."""


class CertificateError(InputError):
    """Text that is not a certificate."""


def read_json(text: str) -> Any:
    """The data in JSON text, if it is not too large for memory.

    Raises:
        ValueError: It is no JSON, or holds too many values.
        RecursionError: It is nested too deeply.
    """
    if text.count("[") + text.count("{") > MOST_LISTS or text.count(",") > MOST_VALUES:
        raise ValueError(f"it holds more than {MOST_LISTS} lists or {MOST_VALUES} values")
    return json.loads(text)


def an_object(data: Any, what: str, keys: set[str]) -> dict[str, Any]:
    """The data as an object that has only these keys."""
    if not isinstance(data, dict) or not set(data) <= keys:
        raise CertificateError(f"{what} must be an object with keys of {', '.join(sorted(keys))}")
    return data


def a_list(data: Any, what: str, limit: int) -> list[Any]:
    """The data as a list that is not too long."""
    if not isinstance(data, list) or len(data) > limit:
        raise CertificateError(f"{what} must be a list of at most {limit}")
    return data


def an_integer(data: Any, what: str, low: int, high: int) -> int:
    """The data as an integer within bounds."""
    if not isinstance(data, int) or isinstance(data, bool) or not low <= data <= high:
        raise CertificateError(f"{what} must be an integer from {low} to {high}")
    return data


def a_text(data: Any, what: str) -> str:
    """The data as text that is not too long."""
    if not isinstance(data, str) or len(data) > MAX_TEXT:
        raise CertificateError(f"{what} must be text of at most {MAX_TEXT} characters")
    return data


def a_fraction(data: Any) -> str:
    """The data as a fraction in text, such as "-3/2"."""
    if not isinstance(data, str) or not FRACTION.fullmatch(data):
        raise CertificateError(f"a number must be a fraction as text, got {str(data)[:40]!r}")
    return data


def coefficients(data: Any) -> Coefficients:
    """The data as coefficients, at least one."""
    values = tuple(a_fraction(value) for value in a_list(data, "coefficients", MAX_FIELD))
    if not values:
        raise CertificateError("a number has a coefficient")
    return values


def pairs(data: Any, what: str) -> tuple[tuple[int, int], ...]:
    """The data as pairs of natural numbers."""
    pairs = [a_list(pair, what, 2) for pair in a_list(data, what, 100)]
    if any(len(pair) != 2 for pair in pairs):
        raise CertificateError(f"{what} are pairs")
    return tuple((an_integer(a, what, 0, MAX_DEGREE), an_integer(b, what, 0, MAX_DEGREE)) for a, b in pairs)
