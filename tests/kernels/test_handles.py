"""Arrays that compiled code reads where NumPy keeps them, against what NumPy says of them."""

import numpy as np
import pytest

from robust_ik.kernels.compiler.array_handles import is_matrix, is_vector, numbers_of
from robust_ik.kernels.compiler.compiling import HANDLE, WHOLE, kernel
from robust_ik.kernels.loader.array_layout import ALIGNED, CONTIGUOUS, WRITEABLE
from robust_ik.kernels.loader.kernel import Kernel

PLAIN = CONTIGUOUS | ALIGNED


@kernel(WHOLE, WHOLE, WHOLE, HANDLE)
def read_vector(array_class, length, flags, handle):
    return is_vector(handle, array_class, length, flags)


@kernel(WHOLE, WHOLE, WHOLE, WHOLE, HANDLE)
def read_matrix(array_class, rows, columns, flags, handle):
    return is_matrix(handle, array_class, rows, columns, flags)


@kernel(WHOLE, HANDLE)
def read_number(index, handle):
    return numbers_of(handle)[index]


vector, matrix, number = (Kernel(__name__, name) for name in ("read_vector", "read_matrix", "read_number"))


def arrays():
    """Of all kinds of types, orders, strides and classes."""
    base = np.arange(48, dtype=float)
    locked = base[:12].copy()
    locked.flags.writeable = False
    shapes = [(12,), (3, 4), (4, 3), (1, 12), (2, 3, 2), (0,), (4, 4), (16,)]
    made = [base[: int(np.prod(shape))].reshape(shape) for shape in shapes]
    made += [each.astype(kind) for each in made for kind in ("f4", "f8", ">f8", "i8", "u8", "c16", "?", "O", "m8[s]")]
    made += [np.asfortranarray(base[:12].reshape(3, 4)), base[::2], base[::-1], base.reshape(6, 8)[:3, :4], base[5:17]]
    made += [np.frombuffer(b"x" + base.tobytes(), dtype=float, offset=1, count=12), locked, np.array(3.0)]
    made += [np.ma.masked_array(base[:12]), np.rec.array(base[:12]), np.broadcast_to(1.0, 12)]
    return made


OTHERS = (
    None,
    3,
    1.5,
    "abc",
    b"\0" * 96,
    [1.0] * 12,
    (1.0,) * 12,
    np.float64(2),
    bytearray(96),
    memoryview(b"abc"),
    int,
)


def plain(array, shape, writeable=False):
    """What NumPy says."""
    native = type(array) is np.ndarray and array.dtype == np.float64 and array.dtype.isnative
    good = native and array.shape == shape and array.flags.c_contiguous and array.flags.aligned
    return bool(good and (array.flags.writeable or not writeable))


@pytest.mark.parametrize("writeable", (False, True))
def test_arrays_of_doubles_are_told_from_all_else(writeable):
    flags = PLAIN | WRITEABLE if writeable else PLAIN
    seen = set()
    for each in (*arrays(), *OTHERS):
        for length in (0, 3, 12, 16):
            told = vector(id(np.ndarray), length, flags, each)
            assert told == plain(each, (length,), writeable), (each, length)
            seen.add(("vector", told))
        for shape in ((3, 4), (4, 3), (4, 4), (1, 12), (12, 1)):
            told = matrix(id(np.ndarray), *shape, flags, each)
            assert told == plain(each, shape, writeable), (each, shape)
            seen.add(("matrix", told))
    assert len(seen) == 4


def test_numbers_are_read_where_they_are():
    for each in arrays():
        if each.dtype == np.float64 and each.dtype.isnative and each.size and each.flags.c_contiguous:
            assert number(each.size - 1, each) == each.ravel()[-1]
