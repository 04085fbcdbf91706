"""Every exception that robust_ik raises on purpose.

```
RobustIKError
├── InputError (ValueError)        an invalid array or parameter: wrong shape, NaN, out of range
├── NotReachedError                a pose that inverse kinematics did not reach
├── FrameNotFoundError (LookupError)  no frame, link or joint of that name; lists what exists
└── LoadError (ValueError)         a robot that cannot be loaded
    ├── RobotNotFoundError         no robot of that name, no file at that path
    ├── UrdfError                  a URDF that is broken, unsafe or not supported
    ├── TipError                   the tip is ambiguous or no joint moves it
    └── DHError                    a DH table that is broken
```

Messages quote what was given and say what is possible. A message is one line of visible characters; if it is longer
than `LONGEST_MESSAGE` it is cut in the middle.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

from robust_ik.errors.safe_text import visible

LONGEST_MESSAGE = 2_000
"""Most characters of a message: about a screen. Messages quote files, whose contents may be of any length."""
LONGEST_NAME = 120
"""Most characters of a name in a list of names."""
COMPARED = 1_000
"""Most names that are compared with one that was not found. The worst names then take two seconds."""


class RobustIKError(Exception):
    """Base of every exception raised on purpose."""

    def __init__(self, *args: object) -> None:
        super().__init__(*(cut(visible(cut(each))) if isinstance(each, str) else each for each in args))


def cut(text: str, most: int = LONGEST_MESSAGE) -> str:
    """The text, or only its beginning and its end if it is longer than `most`."""
    if len(text) <= most:
        return text
    end = most // 4
    return f"{text[: most - end - 3]} … {text[-end:]}"


class InputError(RobustIKError, ValueError):
    """An invalid array or parameter."""


class NotReachedError(RobustIKError):
    """A pose that inverse kinematics did not reach."""


class FrameNotFoundError(RobustIKError, LookupError):
    """A frame, link or joint name that the robot does not have."""


class LoadError(RobustIKError, ValueError):
    """A robot that cannot be loaded."""


class RobotNotFoundError(LoadError):
    """No robot of that name and no file at that path."""


class UrdfError(LoadError):
    """A URDF that is broken, unsafe or not supported."""


class TipError(LoadError):
    """The tip is ambiguous, or no joint moves it."""


class DHError(LoadError):
    """A DH table that is broken."""


def suggest(given: str, known: Iterable[str], limit: int = 40) -> str:
    """The end of a "not found" message: the nearest names first, then all of them.

    Args:
        given: The name that was not found.
        known: The names that exist.
        limit: How many names to list at the most.

    Returns:
        "did you mean 'tool0'? there are: base, tool0" or a part of it.
    """
    names, given = sorted(set(known)), str(given)
    compared = [name for name in names[:COMPARED] if len(name) <= LONGEST_NAME]
    close = difflib.get_close_matches(given, compared, n=3, cutoff=0.5) if len(given) <= LONGEST_NAME else []
    question = f"did you mean {' or '.join(repr(c) for c in close)}? " if close else ""
    return f"{question}there are: {listed(names, limit)}"


def listed(names: Sequence[str], limit: int = 40) -> str:
    """Names joined by commas, at most `limit` and then their number, long ones shortened; "none" if there are none."""
    rest = f", … ({len(names)} in all)" if len(names) > limit else ""
    return ", ".join(cut(visible(cut(name, LONGEST_NAME)), LONGEST_NAME) for name in names[:limit]) + rest or "none"
