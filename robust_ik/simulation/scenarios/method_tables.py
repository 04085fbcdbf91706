"""Makes inverses, resolvers and limiters, and nothing else, from plain tables: {type = "JParse", gamma = 0.1}."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from robust_ik.analysis.evaluation import DulebaMatched
from robust_ik.control.resolvers import (
    DecoupledPriority,
    LeakingPriority,
    Limiter,
    QuadraticProgram,
    Resolver,
    Saturation,
    Scaling,
    Sliding,
    TaskPriority,
    TaskReconstruction,
    WeightedPriority,
)
from robust_ik.errors import InputError, listed, suggest
from robust_ik.inverses import CLASSES, JParse, RobustInverse
from robust_ik.inverses.baselines import BASELINES

RESOLVERS: tuple[type[Resolver], ...] = (
    TaskPriority,
    DecoupledPriority,
    TaskReconstruction,
    WeightedPriority,
    LeakingPriority,
)
LIMITERS: tuple[type[Limiter], ...] = (Scaling, Sliding, Saturation, QuadraticProgram)
TYPES: tuple[type[Any], ...] = (*CLASSES, *BASELINES, DulebaMatched, *RESOLVERS, *LIMITERS)
KNOWN: Mapping[str, Callable[..., Any]] = {
    **{each.__name__: each for each in TYPES},
    "JParse.from_limits": JParse.from_limits,
}


def method(data: object, where: str) -> Resolver | RobustInverse:
    """An inverse or a resolver from a table with its type and parameters.

    Args:
        data: {"type": "JParse", "gamma": 0.1}; a parameter that is a table with a type is made in the same way.
        where: Its name in messages.

    Raises:
        InputError: There is no such type or parameter, or a value is not valid.
    """
    made = _made(data, where)
    if not isinstance(made, (Resolver, RobustInverse)):
        raise InputError(f'{where} must be a table such as {{ type = "JParse", gamma = 0.1 }}, got {data!r}')
    return made


def _made(data: object, where: str) -> Any:
    if isinstance(data, list):
        return tuple(_made(each, where) for each in data)
    if not isinstance(data, dict) or "type" not in data:
        return data
    kind = data["type"]
    if not isinstance(kind, str) or kind not in KNOWN:
        raise InputError(f"{where}: there is no type {kind!r}; {suggest(str(kind), KNOWN)}")
    parameters = {name: _made(value, f"{where}.{name}") for name, value in data.items() if name != "type"}
    possible = list(inspect.signature(KNOWN[kind]).parameters)
    for name in parameters:
        if name not in possible:
            raise InputError(f"{where}: {kind} has no parameter {name!r}; there are: {listed(possible)}")
    try:
        return KNOWN[kind](**parameters)
    except InputError as error:
        raise InputError(f"{where}: {error}") from error
    except TypeError as error:
        raise InputError(f"{where}: {kind} cannot be made of {parameters}: {error}") from error
