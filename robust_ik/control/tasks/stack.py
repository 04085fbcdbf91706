"""Stacks of tasks, in order of importance."""

from __future__ import annotations

import reprlib
from collections.abc import Sequence
from typing import Any

from robust_ik.control.tasks.base import Task
from robust_ik.errors import InputError

Stack = Sequence[Sequence[Task]] | Sequence[Task]
"""A list of levels, the most important first, each a list of the tasks that share it; a list of tasks is one level."""

Levels = tuple[tuple[Task, ...], ...]
"""A stack that has been checked."""


def checked_levels(name: str, levels: Any) -> Levels:
    """Levels of tasks as tuples, possibly none.

    Args:
        name: Their name for the message.
        levels: What was given; a list of tasks alone is one level.

    Raises:
        InputError: They are no list of lists of tasks; the message says which entry is wrong.
    """
    if type(levels) in (list, tuple) and _are_plain(levels):  # in a loop this is asked at every step
        return tuple(map(tuple, levels))
    if isinstance(levels, (list, tuple)) and levels and all(isinstance(each, Task) for each in levels):
        return (tuple(levels),)
    if not isinstance(levels, (list, tuple)):
        shown = reprlib.repr(levels)
        raise InputError(f"{name} must be a list of levels, each a list of tasks, such as [[task]], got {shown}")
    for level in levels:
        if not isinstance(level, (list, tuple)) or not level:
            shown = reprlib.repr(level)
            raise InputError(f"a level of {name} must be a list of tasks, at least one, such as [task], got {shown}")
        for task in level:
            if not isinstance(task, Task):
                raise InputError(f"{name} must hold tasks, got {reprlib.repr(task)}")
    return tuple(tuple(level) for level in levels)


def _are_plain(levels: Sequence[Any]) -> bool:
    """Whether they are lists or tuples of tasks whose classes have been seen before."""
    for level in levels:
        if type(level) not in (list, tuple) or not level:
            return False
        for task in level:
            if type(task) not in _SEEN:
                if not isinstance(task, Task):
                    return False
                _SEEN.add(type(task))
    return True


_SEEN: set[type] = set()
"""Classes of tasks that have been seen: to look here is faster than to ask an abstract class."""


def checked_stack(stack: Stack | Task) -> Levels:
    """The levels of a stack, at least one; a single task is a stack of its own.

    Raises:
        InputError: As for `checked_levels`, or there is no level.
    """
    if isinstance(stack, Task):
        return ((stack,),)
    levels = checked_levels("a stack", stack)
    if not levels:
        raise InputError("a stack must have at least one level, such as [[task]], got none")
    return levels
