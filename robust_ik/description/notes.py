"""Notes: what the user of a file should know about how it was read, one sentence each."""

from __future__ import annotations

from robust_ik.errors import listed
from robust_ik.errors.safe_text import visible

NAMED = 8
"""Most names that a sentence lists."""
LONGEST = 60
"""Most characters of a name that are shown."""


class Notes:
    """Collects notes; a sentence about several things appears once and lists them."""

    def __init__(self) -> None:
        self._names: dict[str, dict[str, None]] = {}

    def add(self, sentence: str, name: str = "") -> None:
        """Notes a sentence, once for each name.

        Args:
            sentence: The sentence.
            name: The thing it is about, if it is one of several.
        """
        names = self._names.setdefault(sentence, {})
        if name:
            names[name] = None

    def sentences(self) -> tuple[str, ...]:
        """The notes in the order in which they were added, each with the names it is about in front."""
        told = (f"{listed(list(names), NAMED)}: {said}" if names else said for said, names in self._names.items())
        return tuple(map(visible, told))


def named(kind: str, name: object) -> str:
    """A thing for a note or a message, such as: joint 'j1'; long names are cut."""
    text = str(name)
    return f"{kind} {text if len(text) <= LONGEST else text[:LONGEST] + '…'!r}"
