"""Reads NumPy arrays directly in memory, without Numba's conversion of arguments.

Numba's own arrays cost a check of types for each call and a record for each array. A handle is the address of any
Python object. Whether the object is an array of the right kind is read where NumPy keeps it: see `array_layout`.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core.pythonapi import unbox
from numba.extending import NativeValue, intrinsic, models, register_model

from robust_ik.kernels.compiler.compiling import HANDLE, HandleType, inlined
from robust_ik.kernels.compiler.stack_memory import Pointer, at_address
from robust_ik.kernels.loader.array_layout import AXES, CLASS, DATA, DOUBLE, FLAGS, KIND, NATIVE, NUMBER, ORDER, SHAPE


@register_model(HandleType)
class _HandleModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, ir.IntType(64))


@unbox(HandleType)
def _unbox(kind: Any, given: Any, c: Any) -> Any:
    return NativeValue(c.builder.ptrtoint(given, ir.IntType(64)))


def _reader(bits: int) -> Any:
    """A function that reads an integer of `bits` bits at an address."""

    @intrinsic
    def read(typing_context: Any, address: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            found = builder.load(builder.inttoptr(values[0], ir.IntType(bits).as_pointer()))
            return found if bits == 64 else builder.zext(found, ir.IntType(64))

        return types.int64(types.int64), codegen

    return read


byte_at, int32_at, int64_at = _reader(8), _reader(32), _reader(64)


@intrinsic
def address_of(typing_context: Any, handle: Any) -> Any:
    """The address of the object."""
    return types.int64(HANDLE), lambda context, builder, signature, values: values[0]


@inlined
def is_vector(handle: Any, array_class: int, length: int, flags: int) -> bool:
    """Whether the object is an array of class `array_class` with `length` doubles in one axis and these flags."""
    at = address_of(handle)
    return bool(_is_plain(at, array_class, 1, flags) and int64_at(int64_at(at + SHAPE)) == length)


@inlined
def is_matrix(handle: Any, array_class: int, rows: int, columns: int, flags: int) -> bool:
    """Whether the object is an array of class `array_class` with rows × columns doubles and these flags."""
    at = address_of(handle)
    if not _is_plain(at, array_class, 2, flags):
        return False
    shape = int64_at(at + SHAPE)
    return bool(int64_at(shape) == rows and int64_at(shape + 8) == columns)


@inlined
def _is_plain(at: int, array_class: int, axes: int, flags: int) -> bool:
    if int64_at(at + CLASS) != array_class or int32_at(at + AXES) != axes or int32_at(at + FLAGS) & flags != flags:
        return False
    kind = int64_at(at + KIND)
    return bool(int32_at(kind + NUMBER) == DOUBLE and byte_at(kind + ORDER) == NATIVE)


@inlined
def numbers_of(handle: Any) -> Pointer:
    """Pointer to the first of an array's doubles."""
    return at_address(int64_at(address_of(handle) + DATA))
