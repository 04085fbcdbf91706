"""Inverses chosen by name."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from robust_ik.errors import InputError, suggest

if TYPE_CHECKING:
    from robust_ik.inverses import RobustInverse


def inverse_class(name: str, classes: Iterable[type[RobustInverse]]) -> type[RobustInverse]:
    """The class of that name, however it is capitalised.

    Raises:
        InputError: There is none; the nearest name is told.
    """
    by_name = {each.__name__: each for each in classes}
    found = next((each for known, each in by_name.items() if known.lower() == name.lower()), None)
    if found is None:
        raise InputError(f"there is no method {name!r}; {suggest(name, by_name)}")
    return found
