"""SIMD lanes: a type of eight numbers that go through the same arithmetic at once, for eight matrices side by side.

Kernels are written once, for numbers. Given lanes, they do the same for eight numbers, and each lane gets the bits that
it would get alone. Instead of a branch, kernels use `where`; a branch on lanes does not compile. A number that meets
lanes counts as eight equal ones.
"""

from __future__ import annotations

import math
import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, lower_cast, models, overload, register_model, type_callable

COUNT = 8
"""Doubles side by side: as many as a register of AVX-512 holds (64 bytes), or two of AVX2."""
DOUBLES = ir.VectorType(ir.DoubleType(), COUNT)
BITS = ir.VectorType(ir.IntType(1), COUNT)

Number = Any
"""A float, or eight of them side by side."""


class LanesType(types.Type):
    """Some doubles side by side."""

    def __init__(self, count: int) -> None:
        super().__init__(name=f"Lanes({count})")
        self.vector = ir.VectorType(ir.DoubleType(), count)

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        """Allows a number where lanes are wanted: `total = 0.0` may begin a sum of lanes."""
        return Conversion.safe if isinstance(other, types.Float) else None


class MaskType(types.Type):
    """Eight truth values."""

    def __init__(self) -> None:
        super().__init__(name=f"Mask({COUNT})")

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        """As for lanes: what begins as a number is compared, and becomes lanes in the first round of a loop."""
        return Conversion.safe if isinstance(other, types.Boolean) else None


LANES, FOUR, MASK = LanesType(COUNT), LanesType(4), MaskType()
"""`FOUR` is for equal arithmetic within one configuration, such as on the components of a vector."""


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, kind.vector)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, BITS)


@lower_cast(types.Boolean, MaskType)
def _cast_truth(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    return _splat(builder, given, value, BITS)


def _splat(builder: Any, kind: Any, value: Any, vector: Any = DOUBLES) -> Any:
    """A vector with the number in every lane; lanes are returned unchanged."""
    if isinstance(kind, LanesType):
        return value
    alone = builder.insert_element(ir.Constant(vector, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), vector.count), [0] * vector.count)
    return builder.shuffle_vector(alone, ir.Constant(vector, ir.Undefined), zeros)


@lower_cast(types.Float, LanesType)
def _cast(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    return _splat(builder, given, value, wanted.vector)


def _is_number(kind: Any) -> bool:
    return isinstance(kind, (LanesType, types.Float))


def _offer(function: Any, result: Any, made: Any) -> None:
    """Defines an operator for lanes, and for lanes and a number.

    Args:
        function: A function of the module operator.
        result: The type of its result; None for the type of the lanes.
        made: Makes the instruction from a builder and two vectors.
    """

    class Template(AbstractTemplate):
        def generic(self, arguments: Any, keywords: Any) -> Any:
            lanes = {each for each in arguments if isinstance(each, LanesType)}
            if len(arguments) == 2 and len(lanes) == 1 and all(map(_is_number, arguments)):
                return signature(result or lanes.pop(), *arguments)
            return None

    def lowered(context: Any, builder: Any, given: Any, values: Any) -> Any:
        vector = next(kind.vector for kind in given.args if isinstance(kind, LanesType))
        return made(builder, *(_splat(builder, kind, value, vector) for kind, value in zip(given.args, values)))

    infer_global(function)(Template)
    for kinds in ((LanesType, LanesType), (LanesType, types.Float), (types.Float, LanesType)):
        lower_builtin(function, *kinds)(lowered)


for _operator, _in_place, _instruction in (
    (operator.add, operator.iadd, "fadd"),
    (operator.sub, operator.isub, "fsub"),
    (operator.mul, operator.imul, "fmul"),
    (operator.truediv, operator.itruediv, "fdiv"),
):
    for _either in (_operator, _in_place):
        _offer(_either, None, lambda builder, x, y, name=_instruction: getattr(builder, name)(x, y))
for _pick, _symbol in ((max, ">"), (min, "<")):  # as Python: the first one, unless the second is beyond it
    _offer(_pick, None, lambda builder, x, y, symbol=_symbol: builder.select(builder.fcmp_ordered(symbol, y, x), y, x))
for _operator, _symbol in ((operator.gt, ">"), (operator.ge, ">="), (operator.lt, "<"), (operator.le, "<=")):
    _offer(_operator, MASK, lambda builder, x, y, symbol=_symbol: builder.fcmp_ordered(symbol, x, y))


@infer_global(operator.and_)
class _And(AbstractTemplate):
    def generic(self, arguments: Any, keywords: Any) -> Any:
        return signature(MASK, MASK, MASK) if tuple(arguments) == (MASK, MASK) else None


@lower_builtin(operator.and_, MaskType, MaskType)
def _and(context: Any, builder: Any, given: Any, values: Any) -> Any:
    return builder.and_(*values)


def _llvm(name: str) -> Any:
    """The code generator of a function of one number as an instruction of LLVM, for numbers and for lanes."""

    def lowered(context: Any, builder: Any, given: Any, values: Any) -> Any:
        kind = context.get_data_type(given.return_type)
        suffix = f"v{COUNT}f64" if given.return_type == LANES else "f64"
        made = ir.FunctionType(kind, [kind])
        return builder.call(cgutils.get_or_insert_function(builder.module, made, f"llvm.{name}.{suffix}"), values)

    return lowered


def root(x: Number) -> Number:
    """√x."""
    raise NotImplementedError


def size(x: Number) -> Number:
    """|x|."""
    raise NotImplementedError


for _function, _name in ((root, "sqrt"), (size, "fabs")):
    type_callable(_function)(lambda context: lambda x: x if _is_number(x) else None)
    for _kind in (LanesType, types.Float):
        lower_builtin(_function, _kind)(_llvm(_name))


@overload(abs, strict=False)
def _abs(x: Any) -> Any:
    return (lambda x: size(x)) if isinstance(x, LanesType) else None


@overload(math.sqrt, strict=False)
def _sqrt(x: Any) -> Any:
    return (lambda x: root(x)) if isinstance(x, LanesType) else None


@overload(operator.neg, strict=False)
def _neg(x: Any) -> Any:
    return (lambda x: -1.0 * x) if isinstance(x, LanesType) else None


@overload(int, strict=False)
def _int(x: Any) -> Any:
    """The whole number that all lanes share, such as a count; of others that of the first lane."""
    return (lambda x: int(first(x))) if isinstance(x, LanesType) else None


@intrinsic
def first(typing_context: Any, value: Any) -> Any:
    """The number in the first lane."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.extract_element(values[0], ir.Constant(ir.IntType(32), 0))

    return types.float64(value), codegen


def where(condition: Any, x: Number, y: Number) -> Number:
    """Selects x where the condition holds, else y; both are computed."""
    raise NotImplementedError


@type_callable(where)
def _type_where(context: Any) -> Any:
    return lambda condition, x, y: LANES if condition == MASK else types.float64


@lower_builtin(where, MaskType, types.Any, types.Any)
def _where_lanes(context: Any, builder: Any, given: Any, values: Any) -> Any:
    return builder.select(values[0], *(_splat(builder, kind, value) for kind, value in zip(given.args[1:], values[1:])))


@lower_builtin(where, types.Boolean, types.Float, types.Float)
def _where_number(context: Any, builder: Any, given: Any, values: Any) -> Any:
    return builder.select(*values)


def somewhere(condition: Any) -> bool:
    """Whether a condition holds in any lane."""
    raise NotImplementedError


type_callable(somewhere)(lambda context: lambda condition: types.boolean)


@lower_builtin(somewhere, types.Boolean)
def _somewhere_number(context: Any, builder: Any, given: Any, values: Any) -> Any:
    return values[0]


@lower_builtin(somewhere, MaskType)
def _somewhere_lanes(context: Any, builder: Any, given: Any, values: Any) -> Any:
    bits = builder.bitcast(values[0], ir.IntType(COUNT))
    return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(COUNT), 0))


@intrinsic
def spread(typing_context: Any, value: Any) -> Any:
    """Eight lanes of the same number."""
    return LANES(value), lambda context, builder, signature, values: _splat(builder, signature.args[0], values[0])


@intrinsic
def folded(typing_context: Any, value: Any) -> Any:
    """The sum of the lanes, halves first: ((0+4)+(2+6)) + ((1+5)+(3+7))."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        index = ir.IntType(32)
        part, count = values[0], COUNT
        while count > 1:
            count //= 2
            halves = [ir.Constant(ir.VectorType(index, count), list(range(k, k + count))) for k in (0, count)]
            low, high = (builder.shuffle_vector(part, ir.Constant(part.type, ir.Undefined), half) for half in halves)
            part = builder.fadd(low, high)
        return builder.extract_element(part, ir.Constant(index, 0))

    return types.float64(value), codegen
