"""Compiles a kernel without machine code of its own for every helper.

Numba assembles each function that compiled code calls, although a kernel links their intermediate code and calls none
of that machine code. What is linked is optimised as always: left as it is, it crashed on processors without AVX.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.codegen import JITCodeLibrary, JITCPUCodegen


@contextmanager
def helpers_only_linked(kernel: str) -> Iterator[None]:
    """While this is open, only the function of this name gets machine code; those that it calls are linked to it.

    It replaces two methods of Numba's compiler for that time; Numba's compiler lock is held by then.
    """
    finish = JITCodeLibrary._finalize_final_module  # noqa: SLF001
    set_environment, later = JITCPUCodegen.set_env, []

    def finished(library: Any) -> None:
        if library.name == kernel:
            finish(library)
        library._finalized = True  # noqa: SLF001

    def environment_set(codegen: Any, name: str, environment: Any) -> None:
        # The variable of a helper is in memory only when the kernel is.
        later.append((codegen, name, environment))

    JITCodeLibrary._finalize_final_module, JITCPUCodegen.set_env = finished, environment_set  # noqa: SLF001
    try:
        yield
    finally:
        del JITCodeLibrary._finalize_final_module  # the class inherits its own  # noqa: SLF001
        JITCPUCodegen.set_env = set_environment
    for codegen, name, environment in later:
        if codegen._engine.is_symbol_defined(name):  # noqa: SLF001
            set_environment(codegen, name, environment)
