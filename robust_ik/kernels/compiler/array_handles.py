"""Reads NumPy arrays directly in memory, without Numba's conversion of arguments.

Numba's own arrays cost a check of types for each call and a record for each array. A handle is the address of any
Python object. Whether the object is an array of the right kind is read from fixed places in memory; NumPy's binary
interface fixes them, since every extension module uses them.

Source: NumPy's reference, "Python types and C structures": PyArrayObject and PyArray_Descr.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.pythonapi import unbox
from numba.extending import NativeValue, intrinsic, models, register_model

from robust_ik.kernels.compiler.compiling import HANDLE, HandleType, inlined
from robust_ik.kernels.compiler.stack_memory import Pointer, at_address

HEAD = object.__basicsize__
"""Bytes of the header of every Python object; the last 8 hold the address of its class."""
CLASS = HEAD - 8
"""Offset of that address."""
DATA, AXES, SHAPE, KIND, FLAGS = HEAD, HEAD + 8, HEAD + 16, HEAD + 40, HEAD + 48
"""Offsets in an array object: address of its numbers, number of axes, addresses of its shape and its dtype, flags."""
ORDER, NUMBER = HEAD + 10, HEAD + 12
"""Offsets in a dtype object: its byte order, a character, and its type number."""
NATIVE, DOUBLE = ord("="), np.dtype(float).num
"""Byte order and type number of doubles in this machine's order of bytes."""
CONTIGUOUS, ALIGNED, WRITEABLE = 0x1, 0x100, 0x400
"""Bits of the flags: NPY_ARRAY_C_CONTIGUOUS, NPY_ARRAY_ALIGNED and NPY_ARRAY_WRITEABLE of NumPy's ndarraytypes.h."""


def _expect_arrays() -> None:
    """Raises if NumPy lays arrays out otherwise in memory: what is read then would be nonsense."""

    def whole(address: int) -> int:
        return ctypes.c_int64.from_address(address).value

    def half(address: int) -> int:
        return ctypes.c_int32.from_address(address).value

    array, flags = np.zeros((3, 5)), CONTIGUOUS | ALIGNED | WRITEABLE
    at, kind = id(array), id(array.dtype)
    found = whole(at + CLASS), whole(at + DATA), half(at + AXES), half(at + FLAGS) & flags, whole(at + KIND)
    good = found == (id(np.ndarray), array.ctypes.data, 2, flags, kind)
    good = good and (half(kind + NUMBER), ctypes.c_ubyte.from_address(kind + ORDER).value) == (DOUBLE, NATIVE)
    if not good or (whole(whole(at + SHAPE)), whole(whole(at + SHAPE) + 8)) != (3, 5):
        raise ImportError(f"NumPy {np.__version__} keeps arrays in memory otherwise than its versions 1 and 2 do")


_expect_arrays()


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
