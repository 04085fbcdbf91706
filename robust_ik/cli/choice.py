"""Chooses inverses and resolvers by name."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from robust_ik.errors import InputError, suggest

Kind = TypeVar("Kind")


def class_of(name: str, classes: Iterable[type[Kind]]) -> type[Kind]:
    """The class of that name, ignoring case.

    Raises:
        InputError: There is none; the message gives the nearest name.
    """
    by_name = {each.__name__: each for each in classes}
    found = next((each for known, each in by_name.items() if known.lower() == name.lower()), None)
    if found is None:
        raise InputError(f"there is no method {name!r}; {suggest(name, by_name)}")
    return found
