"""Loads machine code, and makes functions for Python of it.

The code is an object file as compilers write them, for one machine; before it, a line names what it calls of others:
the C library, its mathematics, and Python's C interface. Its entry is the symbol `entry`. LLVM's linker places it in
memory, where it stays until the process ends.

Source: Python's C interface, "Common object structures": PyMethodDef, and "METH_FASTCALL".
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

ENTRY = "entry"
"""The symbol where each object file is entered."""
MARK = b"machine code:"
"""How the first line begins."""
SHORTEST = 64
"""Bytes that any object file has: the header of one of 64-bit ELF."""
KNOWN = (np.ndarray, TypeError, RuntimeError, None)
"""Objects that machine code refers to; each function is given them as its first argument."""
FASTCALL = 0x0080
"""METH_FASTCALL: the arguments come as a C array of objects and its length."""


class _Method(ctypes.Structure):
    """PyMethodDef."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("address", ctypes.c_void_p),
        ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    )


_kept: list[Any] = []
"""What must live as long as the process: tables of methods, and the bytes of object files."""


def load(content: bytes) -> int:
    """The address of the entry of machine code.

    Raises:
        Exception: It is no object file for this machine, or calls what this process does not have.
    """
    import llvmlite.binding as llvm

    named, _, code = content.partition(b"\n")
    if not named.startswith(MARK) or len(code) < SHORTEST:
        raise ValueError("it is no machine code")  # LLVM would end the process
    for name in named.removeprefix(MARK).decode("ascii").split():
        _find(llvm, name)
    engine = _engine(llvm)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    address = int(engine.get_function_address(ENTRY))
    if not address:
        raise ValueError("it has no entry")
    engine.detach()  # never freed: a function may be called as late as Python ends
    _kept.append((engine, code))
    return address


def function_at(address: int, name: str) -> Callable[..., Any]:
    """A function for Python whose C function is at an address."""
    method = _Method(name.encode(), address, FASTCALL, None)
    _kept.append(method)
    make = ctypes.pythonapi.PyCFunction_NewEx
    make.restype, make.argtypes = ctypes.py_object, (ctypes.POINTER(_Method), ctypes.py_object, ctypes.c_void_p)
    made: Callable[..., Any] = make(ctypes.byref(method), KNOWN, None)
    return made


def _engine(llvm: Any) -> Any:
    """A place in memory for machine code."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(jit=True)
    return llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)


def _find(llvm: Any, name: str) -> None:
    """Sees to it that LLVM finds a symbol: it would end the process otherwise."""
    if llvm.address_of_symbol(name) is not None:
        return
    if (address := address_in_process(name)) is not None:
        llvm.add_symbol(name, address)
        return
    from numba.core.registry import cpu_target

    cpu_target.target_context  # noqa: B018 - loads the mathematics that Numba brings where it is not the C library's
    if llvm.address_of_symbol(name) is None:
        raise ImportError(f"{name} is nowhere in this process")


def address_in_process(name: str) -> int | None:
    """The address of a C function of Python or of a library that it is linked to; None if there is none."""
    found = getattr(ctypes.pythonapi, name, None)
    return None if found is None else ctypes.cast(found, ctypes.c_void_p).value
