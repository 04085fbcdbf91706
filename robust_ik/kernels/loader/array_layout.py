"""Where NumPy keeps the parts of an array in memory, which compiled code reads there.

NumPy's binary interface fixes these places, since every extension module uses them.

Source: NumPy's reference, "Python types and C structures": PyArrayObject and PyArray_Descr.
"""

from __future__ import annotations

import ctypes

import numpy as np

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
