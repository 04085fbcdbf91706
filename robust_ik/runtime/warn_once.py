"""Notes to the user of the program, each logged once."""

from __future__ import annotations

import logging
from collections.abc import Iterable

LOGGER = logging.getLogger("robust_ik")
MOST_TOLD = 1000
"""Most notes that are remembered: the memory of a program that reads files for days does not grow."""
_TOLD: set[str] = set()


def warn_once(about: str, notes: Iterable[str]) -> None:
    """Logs notes as warnings, except those that were logged before.

    Args:
        about: What the notes are about, a file for example.
        notes: One sentence each.
    """
    for note in notes:
        said = f"{about}: {note}"
        if said not in _TOLD:
            if len(_TOLD) >= MOST_TOLD:
                _TOLD.clear()
            _TOLD.add(said)
            LOGGER.warning("%s", said)
