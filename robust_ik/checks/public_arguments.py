"""Checks arguments against a function's annotations, for public functions that are not called in loops.

A wrong type (a string for a number, something else than a robot) is refused with one sentence at once, before it fails
somewhere in the middle. Ranges, shapes and names are checked by the function itself.
"""

from __future__ import annotations

import functools
import inspect
import os
import re
import reprlib
from collections.abc import Callable, Iterable, Mapping
from numbers import Integral, Real
from typing import Any, ParamSpec, TypeVar

import numpy as np

from robust_ik.checks import is_masked
from robust_ik.errors import InputError

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

ARRAYS = ("Array", "ArrayLike", "NDArray")
CALLED = ("Callable", "ProgressCallback", "Function", "Progress")
MANY = ("Sequence", "Iterable", "tuple", "list")
NAMED = {
    "Certificate": "a Certificate", "DHTable": "a DHTable", "Explanation": "an Explanation",
    "LiveServer": "a LiveServer", "Proof": "a Proof", "RobustInverse": "a RobustInverse", "Robot": "a Robot",
    "Scenario": "a Scenario", "Scene": "a Scene", "SingularValueFilter": "a SingularValueFilter",
    "SingularityAtlas": "a SingularityAtlas", "BenchmarkResults": "a BenchmarkResults",
    "MethodSummary": "a MethodSummary",
    "Stratum": "a Stratum", "Trajectory": "a Trajectory", "Verdict": "a Verdict", "WorkspaceMap": "a WorkspaceMap",
    "Status": "a Status", "Obstacle": "an Obstacle", "Descent": "a Descent", "Generator": "a numpy Generator",
}  # fmt: skip
"""Names of classes, and what messages call them: a class is recognised by name, so that nothing has to be imported."""
PLAIN: Mapping[str, tuple[str, Callable[[Any], bool]]] = {
    "None": ("None", lambda value: value is None),
    "str": ("a str", lambda value: isinstance(value, str)),
    "Path": ("a path", lambda value: isinstance(value, os.PathLike)),
    "bool": ("True or False", lambda value: isinstance(value, (bool, np.bool_))),
    "int": ("a whole number", lambda value: isinstance(value, Integral) and not isinstance(value, bool)),
    "float": ("a number", lambda value: _is_number(value)),
}
"""For each plain type: what messages call it, and the test of a value."""


def checked_but(*own: str) -> Callable[[Callable[Parameters, Result]], Callable[Parameters, Result]]:
    """`checked`, except for arguments that the function checks itself with a better message.

    Args:
        own: Names of these arguments.
    """
    return functools.partial(checked, own=own)


def checked(function: Callable[Parameters, Result], own: tuple[str, ...] = ()) -> Callable[Parameters, Result]:
    """The function, with a check that each argument has the type that its annotation names.

    Args:
        function: Any.
        own: Names of arguments that are not checked here, since the function does it.

    Raises:
        InputError: An argument has another type; the message names it.
    """

    @functools.cache
    def wanted() -> tuple[inspect.Signature, dict[str, str]]:
        signature = inspect.signature(function)
        annotations = {name: str(each.annotation) for name, each in signature.parameters.items()}
        return signature, {name: text for name, text in annotations.items() if name not in ("self", "cls", *own)}

    @functools.wraps(function)
    def called(*arguments: Parameters.args, **named: Parameters.kwargs) -> Result:
        signature, annotations = wanted()
        for name, value in signature.bind(*arguments, **named).arguments.items():
            if name in annotations:
                check_type(name, value, annotations[name])
        return function(*arguments, **named)

    return called


def computed(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """`checked` for a function of numbers alone; a result with NaN, from an overflow on the way, raises too.

    Raises:
        InputError: An argument has another type, or the numbers given are too large or too small.
    """
    judged = checked(function)

    @functools.wraps(function)
    def called(*arguments: Parameters.args, **named: Parameters.kwargs) -> Result:
        with np.errstate(all="ignore"):
            result = judged(*arguments, **named)
        if isinstance(result, (float, np.ndarray)) and np.isnan(result).any():
            given = ", ".join(map(shown, [*arguments, *named.values()]))
            raise InputError(f"{function.__name__} overflows for what was given: {given}")
        return result

    return called


def check_type(name: str, value: Any, annotation: str) -> None:
    """Raises unless the value has one of the types in the annotation; unknown type names accept anything.

    Raises:
        InputError: It has none of them.
    """
    kinds = _alternatives(annotation)
    if not any(_fits(value, kind) for kind in kinds):
        ordered = sorted(kinds, key=lambda kind: 2 if kind == "None" else "[" in kind)  # single values first, None last
        wanted = " or ".join(dict.fromkeys(map(_words, ordered)))
        raise InputError(f"{name} must be {wanted}, got {shown(value)}")


def shown(value: object) -> str:
    """The value's repr, shortened, for a message; its type if its repr raises."""
    try:
        return reprlib.repr(value)
    except Exception:
        return f"a {type(value).__name__}"


@functools.cache
def _alternatives(annotation: str) -> tuple[str, ...]:
    """The members of a union: the annotation split at bars outside brackets."""
    parts, depth = [""], 0
    for letter in annotation:
        depth += (letter == "[") - (letter == "]")
        if letter == "|" and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return tuple(part.strip() for part in parts)


@functools.cache
def _taken_apart(kind: str) -> tuple[str, tuple[str, ...]]:
    """The name of a type without its module, and its arguments in brackets."""
    outer, _, inner = kind.partition("[")
    found: list[str] = [""]
    depth = 0
    for letter in inner.removesuffix("]"):
        depth += (letter == "[") - (letter == "]")
        if letter == "," and depth == 0:
            found.append("")
        else:
            found[-1] += letter
    return outer.rpartition(".")[2], tuple(each.strip() for each in found if each.strip() not in ("", "..."))


def _fits(value: Any, kind: str) -> bool:
    name, inner = _taken_apart(kind)
    if name in PLAIN:
        return PLAIN[name][1](value)
    if name in ARRAYS:
        return _is_array(value)
    if name in CALLED:
        return callable(value)
    if name == "Mapping":
        return isinstance(value, Mapping) and all(_any_fits(each, inner[1:]) for each in value.values())
    if name in MANY:
        if isinstance(value, np.ndarray):
            return _is_array(value) and inner[:1] in ((), ("float",), ("int",), *((each,) for each in ARRAYS))
        if name != "Iterable" and not (hasattr(value, "__len__") and hasattr(value, "__getitem__")):
            return False
        return _is_many(value) and all(_any_fits(each, inner[:1]) for each in _held(value))
    if name in NAMED:
        return any(each.__name__ == name for each in type(value).__mro__)
    return True


def _any_fits(value: Any, annotations: tuple[str, ...]) -> bool:
    return not annotations or any(_fits(value, kind) for kind in _alternatives(annotations[0]))


def _held(value: Any) -> Any:
    """The entries that can be checked without consuming the value; of a range, whose entries are alike, the first."""
    return value[:1] if isinstance(value, range) else value if isinstance(value, (list, tuple)) else ()


def _words(kind: str) -> str:
    name, inner = _taken_apart(kind)
    if name in PLAIN:
        return PLAIN[name][0]
    if name in ARRAYS:
        return "an array of real numbers"
    if name in CALLED:
        return "a function"
    if name in MANY or name == "Mapping":
        held = _words(_alternatives(inner[-1])[0]) if inner else "anything"
        return f"{'a dictionary' if name == 'Mapping' else 'a sequence'}, each {held}"
    return NAMED.get(name, re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name))


def _is_number(value: object) -> bool:
    if isinstance(value, np.ndarray):
        return value.ndim == 0 and value.dtype.kind in "iuf"
    return isinstance(value, Real)


def _is_array(value: object) -> bool:
    """Whether NumPy converts the value to an array of real numbers."""
    if is_masked(value):
        return False
    try:
        return np.asarray(value).dtype.kind in "biuf"
    except Exception:
        return False


def _is_many(value: object) -> bool:
    return (
        isinstance(value, Iterable)
        and not isinstance(value, (str, bytes, Mapping))
        and not (isinstance(value, np.ndarray) and value.ndim == 0)
    )
