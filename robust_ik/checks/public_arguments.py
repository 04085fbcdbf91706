"""Arguments held against what a function's annotations say, for public functions that are not called in loops.

What is no number where one is wanted, or another thing than a robot, is told in a sentence, before it fails somewhere
in the middle. Values are for the function itself to judge: ranges, shapes, names.
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

from robust_ik.errors import InputError

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

ARRAYS = ("Array", "ArrayLike", "NDArray")
CALLED = ("Callable", "Told", "Function", "Progress")
MANY = ("Sequence", "Iterable", "tuple", "list")
NAMED = {
    "Certificate": "a Certificate", "DHTable": "a DHTable", "Explanation": "an Explanation",
    "LiveServer": "a LiveServer", "Proof": "a Proof", "RobustInverse": "a RobustInverse", "Robot": "a Robot",
    "Scenario": "a Scenario", "Scene": "a Scene", "SingularValueFilter": "a SingularValueFilter",
    "SingularityAtlas": "a SingularityAtlas",
    "Stratum": "a Stratum", "Trajectory": "a Trajectory", "Verdict": "a Verdict", "WorkspaceMap": "a WorkspaceMap",
    "Status": "a Status", "Obstacle": "an Obstacle", "Descent": "a Descent", "Generator": "a numpy Generator",
}  # fmt: skip
"""Classes, by name, so that nothing need be imported to tell one."""
PLAIN: Mapping[str, tuple[str, Callable[[Any], bool]]] = {
    "None": ("None", lambda value: value is None),
    "str": ("a str", lambda value: isinstance(value, str)),
    "Path": ("a path", lambda value: isinstance(value, os.PathLike)),
    "bool": ("True or False", lambda value: isinstance(value, (bool, np.bool_))),
    "int": ("a whole number", lambda value: isinstance(value, Integral) and not isinstance(value, bool)),
    "float": ("a number", lambda value: _is_number(value)),
}
"""What to call a type, and what is of it."""


def checked_but(*own: str) -> Callable[[Callable[Parameters, Result]], Callable[Parameters, Result]]:
    """`checked`, but for arguments of which the function says better itself what they must be.

    Args:
        own: Their names.
    """
    return functools.partial(checked, own=own)


def checked(function: Callable[Parameters, Result], own: tuple[str, ...] = ()) -> Callable[Parameters, Result]:
    """The function, which refuses arguments of another type than its annotations name.

    Args:
        function: Any.
        own: Names of arguments that it judges itself.

    Raises:
        InputError: An argument is of another type; the message names it.
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
    """`checked`, for a function of numbers alone: what overflows on the way to a result is told, not given as NaN.

    Raises:
        InputError: An argument is of another type, or the numbers given are too large or too small.
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
    """Refuses a value that is none of what an annotation names; unknown names stand for anything.

    Raises:
        InputError: It is none.
    """
    kinds = _alternatives(annotation)
    if not any(_fits(value, kind) for kind in kinds):
        wanted = " or ".join(dict.fromkeys(map(_words, kinds)))
        raise InputError(f"{name} must be {wanted}, got {shown(value)}")


def shown(value: object) -> str:
    """A value for a message, cut; also one that cannot show itself."""
    try:
        return reprlib.repr(value)
    except Exception:
        return f"a {type(value).__name__}"


@functools.cache
def _alternatives(annotation: str) -> tuple[str, ...]:
    """The parts of a union: those between bars outside brackets."""
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
    """The name of a type, without its module, and what stands in its brackets."""
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
    """What can be looked at without taking it out; the first stands for all of a range."""
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
    """Whether NumPy makes an array of real numbers of it."""
    if isinstance(value, np.ma.MaskedArray):
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
