"""Sentences for the person who runs the program, each logged once."""

from __future__ import annotations

import logging
from collections.abc import Iterable

LOGGER = logging.getLogger("robust_ik")
MOST_TOLD = 1000
"""So many are remembered: a program that reads files for days does not grow."""
_TOLD: set[str] = set()


def tell_once(about: str, notes: Iterable[str]) -> None:
    """Logs notes as warnings, but those that were logged before.

    Args:
        about: What they are about: a file.
        notes: A sentence each.
    """
    for note in notes:
        said = f"{about}: {note}"
        if said not in _TOLD:
            if len(_TOLD) >= MOST_TOLD:
                _TOLD.clear()
            _TOLD.add(said)
            LOGGER.warning("%s", said)
