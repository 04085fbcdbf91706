"""Vectors in world axes: for one configuration, x, y and z side by side; for eight, three times eight lanes.

The same arithmetic applies to each component, so that SIMD speeds up one configuration as well. Each number gets the
bits that it would get alone.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from robust_ik.kernels.compiler.compiling import inlined
from robust_ik.kernels.compiler.simd_lanes import FOUR, LANES, Number

Vector = Any
"""`FOUR` for one configuration, three times `LANES` for eight."""


@intrinsic
def _four(typing_context: Any, a: Any, b: Any, c: Any) -> Any:
    """A vector of three numbers and a zero."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        made = ir.Constant(FOUR.vector, [0.0] * 4)
        for lane, value in enumerate(values):
            made = builder.insert_element(made, value, ir.Constant(ir.IntType(32), lane))
        return made

    return FOUR(types.float64, types.float64, types.float64), codegen


@intrinsic
def _first_three(typing_context: Any, lanes: Any) -> Any:
    """The first three numbers of a vector."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        entries = [builder.extract_element(values[0], ir.Constant(ir.IntType(32), lane)) for lane in range(3)]
        return context.make_tuple(builder, signature.return_type, entries)

    return types.UniTuple(types.float64, 3)(lanes), codegen


def vector(x: Number, y: Number, z: Number) -> Vector:
    """A vector of these components."""
    raise NotImplementedError


@overload(vector, strict=False, inline="always")
def _vector(x: Any, y: Any, z: Any) -> Any:
    return (lambda x, y, z: (x, y, z)) if x == LANES else (lambda x, y, z: _four(x, y, z))


def three_of(a: Vector) -> tuple[Number, Number, Number]:
    """The components of a vector."""
    raise NotImplementedError


@overload(three_of, strict=False, inline="always")
def _three_of(a: Any) -> Any:
    return (lambda a: _first_three(a)) if a == FOUR else (lambda a: a)


def plus(a: Vector, b: Vector, s: Number) -> Vector:
    """The vector a + s b."""
    raise NotImplementedError


@inlined
def _plus_each(a: Number, b: Number, s: Number) -> Number:
    return a + s * b


@overload(plus, strict=False, inline="always")
def _plus(a: Any, b: Any, s: Any) -> Any:
    if a == FOUR:
        return lambda a, b, s: _plus_each(a, b, s)
    return lambda a, b, s: (_plus_each(a[0], b[0], s), _plus_each(a[1], b[1], s), _plus_each(a[2], b[2], s))


def mixed(a: Vector, r: float, b: Vector, s: float, c: Vector, t: float) -> Vector:
    """The vector r a + s b + t c."""
    raise NotImplementedError


@inlined
def _mix_each(a: Number, r: float, b: Number, s: float, c: Number, t: float) -> Number:
    return a * r + b * s + c * t


@overload(mixed, strict=False, inline="always")
def _mixed(a: Any, r: Any, b: Any, s: Any, c: Any, t: Any) -> Any:
    if a == FOUR:
        return lambda a, r, b, s, c, t: _mix_each(a, r, b, s, c, t)
    return lambda a, r, b, s, c, t: (
        _mix_each(a[0], r, b[0], s, c[0], t),
        _mix_each(a[1], r, b[1], s, c[1], t),
        _mix_each(a[2], r, b[2], s, c[2], t),
    )


def turned(a: Vector, b: Vector, c: Number, s: Number) -> tuple[Vector, Vector]:
    """Two perpendicular unit vectors a and b, turned about a × b by the angle of cosine c and sine s."""
    raise NotImplementedError


@inlined
def _turn_each(a: Number, b: Number, c: Number, s: Number) -> tuple[Number, Number]:
    return c * a + s * b, c * b - s * a


@overload(turned, strict=False, inline="always")
def _turned(a: Any, b: Any, c: Any, s: Any) -> Any:
    def side_by_side(a: Vector, b: Vector, c: Number, s: Number) -> tuple[Vector, Vector]:
        x, y, z = _turn_each(a[0], b[0], c, s), _turn_each(a[1], b[1], c, s), _turn_each(a[2], b[2], c, s)
        return (x[0], y[0], z[0]), (x[1], y[1], z[1])

    return (lambda a, b, c, s: _turn_each(a, b, c, s)) if a == FOUR else side_by_side
