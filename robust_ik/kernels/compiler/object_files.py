"""Compiles a function, and all that it calls, to one object file.

Numba optimises each function together with all that it calls, and assembles it, although a kernel links their
intermediate code and calls none of that machine code. Here nothing but the whole is assembled. Nor is anything else
optimised, which halves the time, on processors with AVX: on others, code that was left as it is crashed.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import llvmlite.binding as llvm
import numba
from llvmlite import ir
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler_lock import global_compiler_lock

from robust_ik.kernels.compiler.numba_mathematics import write_frexp, write_ldexp
from robust_ik.kernels.loader.kernel_store import Made
from robust_ik.kernels.loader.machine_code import ENTRY, MARK, address_in_process
from robust_ik.kernels.loader.target import processor

HELPER: dict[str, Any] = {
    "error_model": "numpy",
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,  # makes no arrays and counts no references, for which it would need Numba's runtime library
}

Entry = Callable[[Any, ir.Module, Any], None]
"""Writes the function ENTRY into a module, from Numba's context and its result, whose function it calls."""


def compiled(function: Callable[..., Any], signature: Any, entry: Entry, *, makes_arrays: bool = False) -> Made:
    """The machine code of a function for a signature, or a tuple of types of arguments.

    Args:
        function: It may call what is compiled.
        signature: Of the function.
        entry: Writes what is called from outside.
        makes_arrays: Whether it may make arrays; a process that runs machine code that does imports Numba.
    """
    at_once = "+avx" in processor()[2].split(",")
    with global_compiler_lock:
        dispatcher = numba.njit(**HELPER)(function)
        with _only_linked(at_once):
            dispatcher.compile(signature)
        (result,) = dispatcher.overloads.values()
        library = result.library
        if at_once:
            library._optimize_final_module()  # noqa: SLF001
        written = library.codegen.create_library(ENTRY).create_ir_module(ENTRY)
        entry(result.target_context, written, result)
        write_frexp(written)
        write_ldexp(written)
        whole = llvm.parse_assembly(str(written))
        whole.link_in(library._final_module, preserve=True)  # noqa: SLF001
        content = library.codegen._tm.emit_object(_private(whole))  # noqa: SLF001
    needed = set(_needed(whole))
    if needed >= {"sin", "cos"} and address_in_process("sincos") is not None:
        needed.add("sincos")  # LLVM calls it where both are wanted of a number
    first = b" ".join((MARK, *(name.encode("ascii") for name in sorted(needed))))
    return Made(first + b"\n" + content, _why_fixed(library))


def _needed(module: Any) -> Iterator[str]:
    """The functions of others that machine code calls, or may call for an instruction of LLVM such as llvm.cos.f64."""
    for each in _all(module):
        if each.is_declaration:
            instruction = each.name.startswith("llvm.")
            name = each.name.split(".")[1] if instruction else each.name
            if not instruction or address_in_process(name) is not None:
                yield name


def _all(module: Any) -> Iterator[Any]:
    """The functions and variables of a module."""
    yield from module.functions
    yield from module.global_variables


def _private(module: Any) -> Any:
    """The module, of which only ENTRY is seen from outside."""
    for each in _all(module):
        if not each.is_declaration and each.name != ENTRY:
            each.linkage = "internal"
    return module


def _why_fixed(library: Any) -> str | None:
    """Why machine code serves no other process; None if it does."""
    if library.has_dynamic_globals:
        return "it holds addresses"
    if os.environ.get("NUMBA_CPU_NAME") != numba.config.CPU_NAME:
        return "Numba was told to compile for another processor than the environment names"
    return None


@contextmanager
def _only_linked(at_once: bool) -> Iterator[None]:
    """While this is open, Numba assembles nothing, and optimises no function with what it calls if that is for the end.

    It replaces methods of Numba's compiler for that time; Numba's compiler lock is held by then.
    """
    set_environment = JITCPUCodegen.set_env

    def finished(library: Any) -> None:
        library._finalize_dynamic_globals()  # noqa: SLF001
        library._finalized = True  # noqa: SLF001

    replaced = {"_finalize_final_module": finished}
    if at_once:
        replaced["_optimize_final_module"] = lambda library: None
    for name, method in replaced.items():
        setattr(JITCodeLibrary, name, method)
    JITCPUCodegen.set_env = lambda codegen, name, environment: None  # there is no variable to set in memory
    try:
        yield
    finally:
        for name in replaced:
            delattr(JITCodeLibrary, name)  # the class inherits its own
        JITCPUCodegen.set_env = set_environment
