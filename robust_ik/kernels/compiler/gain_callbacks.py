"""Compiles gain formulas to functions that kernels call by address."""

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
"""From σ, σ₁, the smallest σ, Π σ, how many σ come after this one, and a pointer to the parameters, to the gain."""

_callbacks: dict[Callable[..., Any], Any] = {}
"""Compiled formulas, kept so that their addresses stay valid; None for a formula that cannot be compiled."""
_lock = threading.Lock()
_known: set[FunctionType] = {where}  # type: ignore[arg-type]


@overload(where, strict=False)
def _where(condition: Any, x: Any, y: Any) -> Any:
    return lambda condition, x, y: x if condition else y


def address_of(formula: Callable[..., Any]) -> int | None:
    """The address of the compiled formula; None, with a warning that says why, if it cannot be compiled.

    It is compiled once, in this process or in an earlier one.
    """
    with _lock:  # a second thread must not replace the callback whose address the first one has
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
    """Allows compiled code to call the plain functions that a function uses, and those that they use."""
    for name in function.__code__.co_names:
        other = function.__globals__.get(name)
        if isinstance(other, FunctionType) and other not in _known:
            _known.add(other)
            register_jitable(other)
            _announce(other)
