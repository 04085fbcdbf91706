"""Formulas of gains as functions that kernels call by their address."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable
from types import FunctionType
from typing import Any

from numba import types
from numba.core.errors import NumbaError
from numba.extending import overload, register_jitable

from robust_ik.kernels.compiler.compiling import callback
from robust_ik.kernels.compiler.where import where

SIGNATURE = types.float64(*[types.float64] * 5, types.CPointer(types.float64))
"""σ, σ₁, the smallest σ, Π σ, how many σ come after this one, and the parameters."""

_callbacks: dict[Callable[..., Any], Any] = {}
"""What addresses belong to, which must not be collected; None where there is none."""
_lock = threading.Lock()
_known: set[FunctionType] = {where}  # type: ignore[arg-type]


@overload(where, strict=False)
def _where(condition: Any, x: Any, y: Any) -> Any:
    return lambda condition, x, y: x if condition else y


def address_of(formula: Callable[..., Any]) -> int | None:
    """Where the compiled formula begins, or None where it uses what cannot be compiled; then a warning says what.

    It is compiled once, in this process or in an earlier one.
    """
    with _lock:  # of two threads, one must not drop what the other has the address of
        if formula not in _callbacks:
            _callbacks[formula] = _compiled(formula)
    return None if _callbacks[formula] is None else int(_callbacks[formula].address)


def _compiled(formula: Callable[..., Any]) -> Any:
    _announce(formula)
    try:
        return callback(formula, SIGNATURE)
    except NumbaError as error:
        reason = str(error).strip().splitlines()[0]
        warnings.warn(f"{formula.__qualname__} cannot be compiled and stays Python: {reason}", stacklevel=5)
        return None


def _announce(function: Any) -> None:
    """Lets what is compiled call the plain functions that it names, and those that they name."""
    for name in function.__code__.co_names:
        other = function.__globals__.get(name)
        if isinstance(other, FunctionType) and other not in _known:
            _known.add(other)
            register_jitable(other)
            _announce(other)
