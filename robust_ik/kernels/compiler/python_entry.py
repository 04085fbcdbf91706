"""Writes the C function that Python calls for a kernel: it checks and reads the arguments, and makes the result.

It calls nothing but Python's C interface, so that machine code needs no Numba. Numba's own has to tell more types apart
and needs Numba's runtime library.

A kernel that takes handles is called for microseconds at a time. So it keeps Python's lock: to release it takes time,
and another thread that gets it may hold it for milliseconds.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.np.arrayobj import populate_array

from robust_ik.kernels.loader.array_layout import (
    ALIGNED,
    AXES,
    CLASS,
    CONTIGUOUS,
    DATA,
    DOUBLE,
    FLAGS,
    KIND,
    NATIVE,
    NUMBER,
    ORDER,
    SHAPE,
    WRITEABLE,
)
from robust_ik.kernels.loader.machine_code import ENTRY, KNOWN

OBJECT = ir.IntType(8).as_pointer()
"""PyObject *, or any address."""
LONG, INT, BYTE, DOUBLES = ir.IntType(64), ir.IntType(32), ir.IntType(8), ir.DoubleType()


def python_entry(context: Any, module: ir.Module, result: Any) -> None:
    """Writes ENTRY(`machine_code.KNOWN`, arguments, how many): a new reference, or NULL with an error set."""
    kind = ir.FunctionType(OBJECT, [OBJECT, OBJECT.as_pointer(), LONG])
    function = ir.Function(module, kind, ENTRY)
    _PythonEntry(context, function, result).write()


class _PythonEntry:
    def __init__(self, context: Any, function: ir.Function, result: Any) -> None:
        self._context, self._module, self._described = context, function.module, result.fndesc
        self._known_things, self._given, self._count = function.args
        self._builder = ir.IRBuilder(function.append_basic_block())
        self._name = self._described.qualname.rpartition(".")[2]

    def write(self) -> None:
        builder, described = self._builder, self._described
        count = len(described.argtypes)
        self._expect(
            builder.icmp_signed("==", self._count, LONG(count)), f"takes {count} argument{'s' if count > 1 else ''}"
        )
        values = [self._read(place, kind) for place, kind in enumerate(described.argtypes)]
        callee = self._context.declare_function(self._module, described)
        lock = None if any(map(_is_handle, described.argtypes)) else self._call(OBJECT, "PyEval_SaveThread")
        status, found = self._context.call_conv.call_function(
            builder, callee, described.restype, described.argtypes, values
        )
        if lock is not None:
            self._call(ir.VoidType(), "PyEval_RestoreThread", lock)
        self._expect(status.is_ok, "failed: an index is out of bounds, or an error was raised", RuntimeError)
        builder.ret(self._made(found))

    def _call(self, result: ir.Type, name: str, *arguments: ir.Value) -> ir.Value:
        """A call of Python's C interface."""
        kind = ir.FunctionType(result, [each.type for each in arguments])
        return self._builder.call(cgutils.get_or_insert_function(self._module, kind, name), arguments)

    def _known(self, thing: Any) -> ir.Value:
        """One of the objects that machine code is given; its own names for them mean something else to Numba."""
        return self._call(OBJECT, "PyTuple_GetItem", self._known_things, LONG(KNOWN.index(thing)))

    def _expect(self, condition: ir.Value, text: str, error: type[Exception] = TypeError) -> None:
        """Leaves with an error unless the condition holds."""
        builder = self._builder
        with builder.if_then(builder.not_(condition), likely=False):
            message = self._context.insert_const_string(self._module, f"{self._name} {text}")
            self._call(ir.VoidType(), "PyErr_SetString", self._known(error), message)
            builder.ret(OBJECT(None))

    def _read(self, place: int, kind: Any) -> ir.Value:
        """The value of an argument."""
        builder = self._builder
        thing = builder.load(builder.gep(self._given, [INT(place)]))
        if _is_handle(kind):
            return builder.ptrtoint(thing, LONG)
        if isinstance(kind, types.Array):
            return self._array(thing, kind, place)
        whole = kind == types.int64
        value = self._call(*((LONG, "PyLong_AsLongLong") if whole else (DOUBLES, "PyFloat_AsDouble")), thing)
        told = value.type(-1)
        odd = builder.icmp_signed("==", value, told) if whole else builder.fcmp_ordered("==", value, told)
        with builder.if_then(odd, likely=False):
            raised = builder.icmp_unsigned("!=", self._call(OBJECT, "PyErr_Occurred"), OBJECT(None))
            with builder.if_then(raised):
                builder.ret(OBJECT(None))
        return value

    def _at(self, thing: ir.Value, offset: int, kind: ir.Type) -> ir.Value:
        """What is in memory so many bytes after an address."""
        place = self._builder.gep(thing, [INT(offset)])
        return self._builder.load(self._builder.bitcast(place, kind.as_pointer()))

    def _array(self, thing: ir.Value, kind: Any, place: int) -> ir.Value:
        """Numba's record of an array, which must be of NumPy's own class, of doubles, contiguous, with so many axes."""
        builder, axes = self._builder, kind.ndim
        flags = CONTIGUOUS | ALIGNED | (WRITEABLE if kind.mutable else 0)
        text = (
            f"takes as argument {place + 1} a C-contiguous array of doubles with {axes} ax{'e' if axes > 1 else 'i'}s"
        )
        text += ", which it writes to" if kind.mutable else ""
        self._expect(builder.icmp_unsigned("==", self._at(thing, CLASS, OBJECT), self._known(np.ndarray)), text)
        numbers = self._at(thing, KIND, OBJECT)
        for found, wanted in (
            (self._at(thing, AXES, INT), INT(axes)),
            (builder.and_(self._at(thing, FLAGS, INT), INT(flags)), INT(flags)),
            (self._at(numbers, NUMBER, INT), INT(DOUBLE)),
            (self._at(numbers, ORDER, BYTE), BYTE(NATIVE)),
        ):
            self._expect(builder.icmp_unsigned("==", found, wanted), text)
        lengths = self._at(thing, SHAPE, OBJECT)
        shape = [self._at(lengths, 8 * axis, LONG) for axis in range(axes)]
        strides = [LONG(8)]
        for length in reversed(shape[1:]):
            strides.insert(0, builder.mul(strides[0], length))
        array = self._context.make_array(kind)(self._context, builder)
        populate_array(array, self._at(thing, DATA, DOUBLES.as_pointer()), shape, strides, 8, None)
        return array._getvalue()  # noqa: SLF001

    def _made(self, found: ir.Value) -> ir.Value:
        """The Python object of a result."""
        kind = self._described.restype
        if kind == types.none:
            nothing = self._known(None)
            self._call(ir.VoidType(), "Py_IncRef", nothing)
            return nothing
        if isinstance(kind, types.Boolean):
            return self._call(OBJECT, "PyBool_FromLong", self._cast(found, types.int64))
        if isinstance(kind, types.Integer):
            return self._call(OBJECT, "PyLong_FromLongLong", self._cast(found, types.int64))
        return self._call(OBJECT, "PyFloat_FromDouble", self._cast(found, types.float64))

    def _cast(self, found: ir.Value, kind: Any) -> ir.Value:
        return self._context.cast(self._builder, found, self._described.restype, kind)


def _is_handle(kind: Any) -> bool:
    """Whether a type is the one of handles, which is neither numbers nor arrays of them."""
    return not isinstance(kind, (types.Number, types.Array))
