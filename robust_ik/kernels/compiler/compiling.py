"""Compiles functions: once, for declared types, kept on disk if possible, never inside a loop."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba import types
from numba.core.ccallback import CFunc
from numba.core.compiler_lock import global_compiler_lock

from robust_ik.kernels.compiler.helper_libraries import helpers_only_linked
from robust_ik.kernels.compiler.kernel_store import Store

Function = TypeVar("Function", bound=Callable[..., Any])

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
HELPER: dict[str, Any] = {**OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def inlined(function: Function) -> Function:
    """A helper that is compiled into each function that calls it."""
    jitted: Function = numba.njit(inline="always", **HELPER)(function)
    return jitted


FLOAT, WHOLE = types.float64, types.int64


class HandleType(types.Type):
    """Type of any Python object, given by its address: see `array_handles`."""

    def __init__(self) -> None:
        super().__init__(name="Handle")


HANDLE = HandleType()


def given(axes: int) -> Any:
    """Type of a C-contiguous array of doubles that is only read."""
    return types.Array(FLOAT, axes, "C", readonly=True)


def filled(axes: int) -> Any:
    """Type of a C-contiguous array of doubles that is written to."""
    return types.Array(FLOAT, axes, "C")


def kernel(*arguments: Any) -> Callable[[Function], Kernel]:
    """A function for Python to call, compiled at its first use for these types of arguments and for no others."""

    def made(function: Function) -> Kernel:
        KERNELS.append(Kernel(function, arguments))
        return KERNELS[-1]

    return made


class Kernel:
    """A function that is compiled, or read from disk, at its first use.

    Attributes:
        name: Its name in its module.
        most: Most joints, rows and columns it can handle, from the ending _8 or _16 of its name; None for any number.
        arguments: The types of arguments it takes; others raise TypeError.
    """

    def __init__(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        self._function, self.name, self.arguments = function, function.__qualname__, arguments
        size = self.name.rpartition("_")[2]
        self.most = int(size) if size.isdigit() else None
        self._compiled: Callable[..., Any] | None = None

    @property
    def compiled(self) -> Callable[..., Any]:
        """The compiled function, for calls in a loop: nothing is checked any more. The same for every thread."""
        if self._compiled is None:
            with global_compiler_lock:  # Numba's own lock: with a second one two threads might wait for each other
                if self._compiled is None:
                    self._compiled = compiled(self._function, self.arguments)
        return self._compiled

    def __call__(self, *arguments: Any) -> Any:
        """The function's result."""
        return self.compiled(*arguments)


KERNELS: list[Kernel] = []
"""All kernels of the modules imported so far."""


def every_kernel() -> Sequence[Kernel]:
    """All kernels below `robust_ik.kernels`, after importing every module there."""
    for module in pkgutil.walk_packages([str(Path(__file__).parents[1])], "robust_ik.kernels."):
        importlib.import_module(module.name)
    return tuple(KERNELS)


def compiled(function: Callable[..., Any], arguments: tuple[Any, ...]) -> Callable[..., Any]:
    """A dispatcher for these arguments that compiles no further ones; for handles, the compiled function behind it.

    A kernel that takes handles is called for microseconds at a time. So it keeps Python's lock: to release it takes
    time, and another thread that gets it may hold it for milliseconds.
    """
    brief = HANDLE in arguments
    dispatcher = numba.njit(**{**OPTIONS, "nogil": not brief})(function)
    _keep(dispatcher, function)
    with helpers_only_linked(function.__qualname__):
        dispatcher.compile(arguments)
    dispatcher.disable_compile()
    if brief:
        return dispatcher.overloads[arguments].entry_point  # type: ignore[no-any-return]
    return dispatcher  # type: ignore[no-any-return]


def _keep(made: Any, function: Callable[..., Any]) -> None:
    """Makes a dispatcher look on disk before it compiles, if the source file determines the whole function."""
    with suppress(OSError):
        made._cache = Store(function)  # noqa: SLF001


def callback(function: Callable[..., Any], signature: Any) -> Any:
    """A Numba CFunc, which compiled code calls by its `.address`; the caller must keep a reference to it."""
    made = CFunc(function, (signature.args, signature.return_type), locals={}, options=dict(OPTIONS))
    _keep(made, function)
    made.compile()
    return made


def called(function: Function) -> Function:
    """A helper that is too large to be compiled into every function that calls it."""
    jitted: Function = numba.njit(**HELPER)(function)
    return jitted
