"""Arrays on the stack: their sizes are known when the code is compiled, so they cost nothing to make.

A size n is given as a tuple of length n, since the length of a tuple is part of its type.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from robust_ik.kernels.compiler.simd_lanes import DOUBLES, LANES, Number

Sizes = tuple[int, ...]
Pointer = Any

ALIGNMENT = 64
"""Bytes of eight doubles: LLVM assumes that vectors of them lie at multiples of their size."""


def sizes(count: int) -> Sizes:
    """A tuple that stands for the size `count` in `stack`."""
    return (0,) * count


NONE, ONE, W8, W16 = sizes(0), sizes(1), sizes(8), sizes(16)


@intrinsic
def stack(typing_context: Any, like: Number, rows: Any, width: Any) -> Any:
    """A pointer to rows · width numbers of the type of `like`, with arbitrary content."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        count = ir.Constant(ir.IntType(32), rows.count * width.count)
        pointer = cgutils.alloca_once(builder, context.get_data_type(like), size=count)
        pointer.align = ALIGNMENT
        return pointer

    return types.CPointer(like)(like, rows, width), codegen


@intrinsic
def pointer(typing_context: Any, array: Any) -> Any:
    """A pointer to the first number of a contiguous array; access through it is not checked."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return context.make_array(signature.args[0])(context, builder, values[0]).data

    return types.CPointer(types.float64)(array), codegen


@intrinsic
def at_address(typing_context: Any, address: Any) -> Any:
    """The pointer to the doubles at an address; the caller keeps their memory alive."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.inttoptr(values[0], ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(types.int64), codegen


@intrinsic
def further(typing_context: Any, given: Any, index: Any) -> Any:
    """The pointer moved on by `index` entries."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.gep(values[0], [values[1]])

    return given(given, types.int64), codegen


@intrinsic
def each_lane(typing_context: Any, pointer: Any) -> Any:
    """The same memory as single doubles: entry x of lane l is at x · lanes + l."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.bitcast(values[0], ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(pointer), codegen


@intrinsic
def by_eights(typing_context: Any, pointer: Any) -> Any:
    """The same memory as vectors of eight doubles."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.bitcast(values[0], DOUBLES.as_pointer())

    return types.CPointer(LANES)(pointer), codegen


@intrinsic
def lanes_of(typing_context: Any, like: Any) -> Any:
    """How many doubles a Number of this type holds: 1 or 8."""
    count = 8 if like == LANES else 1
    return types.int64(like), lambda context, builder, signature, values: ir.Constant(ir.IntType(64), count)


@intrinsic
def call_gain(typing_context: Any, address: Any, arguments: Any) -> Any:
    """Calls a compiled gain formula φ by its address: five doubles and a pointer to its parameters."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        double = ir.DoubleType()
        kinds = [double] * 5 + [double.as_pointer()]
        function = builder.inttoptr(values[0], ir.FunctionType(double, kinds).as_pointer())
        rest = [builder.extract_value(values[1], index) for index in range(len(kinds))]
        return builder.call(function, rest)

    return types.float64(address, arguments), codegen
