"""Compiles gain formulas to C functions."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import FunctionType
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.errors import NumbaError
from numba.extending import overload, register_jitable

from robust_ik.kernels.compiler.object_files import compiled
from robust_ik.kernels.compiler.where import where
from robust_ik.kernels.loader.kernel_store import Made, NotCompilableError
from robust_ik.kernels.loader.machine_code import ENTRY

SIGNATURE = types.float64(*[types.float64] * 5, types.CPointer(types.float64))
"""From σ, σ₁, the smallest σ, Π σ, how many σ come after this one, and a pointer to the parameters, to the gain."""

_known: set[FunctionType] = {where}  # type: ignore[arg-type]


@overload(where, strict=False)
def _where(condition: Any, x: Any, y: Any) -> Any:
    return lambda condition, x, y: x if condition else y


def made(formula: Callable[..., Any]) -> Made:
    """The machine code of a formula.

    Raises:
        NotCompilableError: It cannot be compiled; the message is the first line of Numba's.
    """
    _announce(formula)
    try:
        return compiled(formula, SIGNATURE, _entry, makes_arrays=True)
    except NumbaError as error:
        raise NotCompilableError(str(error).strip().splitlines()[0]) from error


def _announce(function: Any) -> None:
    """Allows compiled code to call the plain functions that a function uses, and those that they use."""
    for name in function.__code__.co_names:
        other = function.__globals__.get(name)
        if isinstance(other, FunctionType) and other not in _known:
            _known.add(other)
            register_jitable(other)
            _announce(other)


def _entry(context: Any, module: ir.Module, result: Any) -> None:
    """Writes the C function: the gain, or NaN if the formula raises an error."""
    described = result.fndesc
    double = ir.DoubleType()
    function = ir.Function(module, ir.FunctionType(double, [double] * 5 + [double.as_pointer()]), ENTRY)
    builder = ir.IRBuilder(function.append_basic_block())
    callee = context.declare_function(module, described)
    status, found = context.call_conv.call_function(
        builder, callee, described.restype, described.argtypes, function.args
    )
    builder.ret(builder.select(status.is_ok, found, double(math.nan)))
