"""Commands that a page sends, read from text that nobody can trust."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from robust_ik.errors import InputError, cut

LONGEST = 4_000
"""Most characters of a message. Chosen: a command with the parameters of an inverse takes some 200."""
FARTHEST = 1e6
"""Largest number in a command, rad or m. Chosen: far beyond any robot, and no sum of it overflows."""

FIELDS: dict[str, dict[str, type]] = {
    "joint": {"index": int, "value": float},
    "configuration": {"values": list},
    "rest": {},
    "position": {"values": list},
    "rotation": {"values": list},
    "self_motion": {"index": int, "by": float},
    "family": {"index": int},
    "solutions": {},
    "solution": {"index": int},
    "inverse": {"name": str, "parameters": dict},
}
"""What each command that a page sends takes."""
REPLACED = ("joint", "configuration", "position", "rotation")
"""Commands that a later one of the same joint or kind replaces, if it still waits."""


@dataclass(frozen=True)
class LiveCommand:
    """One command.

    Attributes:
        do: Its name.
        values: What it takes, by name.
    """

    do: str
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def replaced(self) -> tuple[str, object] | None:
        """What it has in common with commands that replace it; None if all of them count."""
        return (self.do, self.values.get("index")) if self.do in REPLACED else None


def read_command(text: str | bytes) -> LiveCommand:
    """The command in a message, {"do": name, ...}.

    Raises:
        InputError: It is too long, no JSON, no command, or lacks a value or has one too many, or one of another kind.
    """
    if not isinstance(text, str) or len(text) > LONGEST:
        raise InputError(f"a command is text of at most {LONGEST} characters, got {len(text)} of {type(text).__name__}")
    try:
        given = json.loads(text, parse_constant=_refused)
    except (ValueError, RecursionError) as error:
        raise InputError(f"a command is JSON: {cut(str(error), 100)}") from None
    if not isinstance(given, dict) or not isinstance(given.get("do"), str) or given["do"] not in FIELDS:
        raise InputError(f"a command says what to do, one of {', '.join(FIELDS)}; got {cut(text, 100)!r}")
    do = given.pop("do")
    wanted = FIELDS[do]
    if given.keys() != wanted.keys():
        raise InputError(f"{do} takes {', '.join(wanted) or 'nothing'}; got {cut(', '.join(given), 100) or 'nothing'}")
    return LiveCommand(do, {name: _value(name, given[name], kind) for name, kind in wanted.items()})


def _value(name: str, given: Any, kind: type) -> Any:
    if kind is float:
        return number(name, given)
    if kind is int and (isinstance(given, bool) or not isinstance(given, int) or not 0 <= given < FARTHEST):
        raise InputError(f"{name} must be a whole number from 0 on, got {cut(repr(given), 100)}")
    if not isinstance(given, kind):
        raise InputError(f"{name} must be {kind.__name__}, got {type(given).__name__}")
    if isinstance(given, list):
        return [number(name, each) for each in given]
    if isinstance(given, dict):
        return {str(key): number(str(key), each) for key, each in given.items()}
    return given


def number(name: str, given: Any) -> float:
    """A finite number of a size that robots have.

    Raises:
        InputError: It is none.
    """
    plain = isinstance(given, (int, float)) and not isinstance(given, bool) and abs(given) <= FARTHEST
    if not plain or not math.isfinite(given):
        raise InputError(f"{cut(name, 40)} must be a finite number up to {FARTHEST:g}, got {cut(repr(given), 100)}")
    return float(given)


def _refused(name: str) -> float:
    raise ValueError(f"{name} is no JSON")
