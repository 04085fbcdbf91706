"""Notes: what a reader of a file should know of how it was taken, a sentence each."""

from __future__ import annotations

from robust_ik.errors import listed
from robust_ik.errors.safe_text import visible

NAMED = 8
"""How many names a sentence lists."""
LONGEST = 60
"""Characters of a name that are shown."""


class Notes:
    """Collects notes; what is said of several things is one sentence that lists them."""

    def __init__(self) -> None:
        self._names: dict[str, dict[str, None]] = {}

    def add(self, sentence: str, name: str = "") -> None:
        """Notes a sentence, once for each name.

        Args:
            sentence: What is said.
            name: The thing it is said of, if it is said of one among others.
        """
        names = self._names.setdefault(sentence, {})
        if name:
            names[name] = None

    def sentences(self) -> tuple[str, ...]:
        """The notes in the order in which they came, each with the things it is said of in front."""
        told = (f"{listed(list(names), NAMED)}: {said}" if names else said for said, names in self._names.items())
        return tuple(map(visible, told))


def named(kind: str, name: object) -> str:
    """A thing for a note or a message, long names cut: joint 'j1'."""
    text = str(name)
    return f"{kind} {text if len(text) <= LONGEST else text[:LONGEST] + '…'!r}"
