"""Makes names from files and users safe and unique for scene paths."""

from __future__ import annotations

import re
from collections.abc import Iterable


def node_names(names: Iterable[str]) -> dict[str, str]:
    """Node names for names: safe characters only, with a number in front.

    A link may have any name. In a scene path "/" would start a new node, and the viewer keeps nodes in a JavaScript
    object, in which names such as "constructor" are taken. The number makes the nodes unique.
    """
    return {
        name: f"{index:02d}_{re.sub(r'[^A-Za-z0-9_.-]', '_', name)[:60]}"
        for index, name in enumerate(dict.fromkeys(names))
    }


def distinct(labels: Iterable[str]) -> list[str]:
    """The labels, with " (2)", " (3)" … appended to repeated ones."""
    used: set[str] = set()
    result = []
    for label in labels:
        candidate, count = label, 1
        while candidate in used:
            count += 1
            candidate = f"{label} ({count})"
        used.add(candidate)
        result.append(candidate)
    return result
