"""Reads numbers in a URDF."""

from __future__ import annotations

import math
import re

LARGEST = 1e6
"""Largest number of metres or radians as written; products overflow far above it."""
NO_LIMIT = 1e6
"""A position limit of at least this magnitude stands for no limit."""
LONGEST = 80
"""Most characters of a text that are shown."""
_NUMBER = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")


def numbers(text: str, largest: float = LARGEST) -> tuple[float, ...] | None:
    """The numbers of a text, separated by blanks; None if a word is not a number or is larger than `largest`."""
    found = tuple(float(word) if _NUMBER.fullmatch(word) else math.nan for word in text.split())
    return found if all(abs(number) <= largest for number in found) else None


def are_numbers(text: str | None, count: int, largest: float = LARGEST) -> bool:
    """Whether a text holds `count` numbers; a missing text passes."""
    if text is None:
        return True
    found = numbers(text, largest)
    return found is not None and len(found) == count


def shown(text: str) -> str:
    """A text for a message; a long one is cut."""
    return repr(text if len(text) <= LONGEST else text[:LONGEST] + "…")
