"""Compiles a kernel without machine code of its own for every helper.

Numba optimises and assembles each function that compiled code calls, although a kernel links their intermediate code,
is optimised as a whole, and calls none of that machine code: most of the compile time of a kernel with many helpers.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.codegen import JITCodeLibrary, JITCPUCodegen


@contextmanager
def helpers_only_linked(kernel: str) -> Iterator[None]:
    """While this is open, only the function of this name gets machine code; those that it calls are linked to it.

    It replaces three methods of Numba's compiler for that time; Numba's compiler lock is held by then.
    """
    optimise, finish = JITCodeLibrary._optimize_final_module, JITCodeLibrary._finalize_final_module  # noqa: SLF001
    set_environment, later = JITCPUCodegen.set_env, []

    def optimised(library: Any) -> None:
        if library.name == kernel:
            optimise(library)

    def finished(library: Any) -> None:
        if library.name == kernel:
            finish(library)
        library._finalized = True  # noqa: SLF001

    def environment_set(codegen: Any, name: str, environment: Any) -> None:
        # The variable of a helper is in memory only when the kernel is.
        later.append((codegen, name, environment))

    replaced = {"_optimize_final_module": optimised, "_finalize_final_module": finished}
    for method, other in replaced.items():
        setattr(JITCodeLibrary, method, other)
    JITCPUCodegen.set_env = environment_set
    try:
        yield
    finally:
        for method in replaced:
            delattr(JITCodeLibrary, method)  # the class inherits its own
        JITCPUCodegen.set_env = set_environment
    for codegen, name, environment in later:
        if codegen._engine.is_symbol_defined(name):  # noqa: SLF001
            set_environment(codegen, name, environment)
