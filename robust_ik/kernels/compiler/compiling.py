"""How a function is compiled: once for declared types, kept on disk where that is possible, never inside a loop."""

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

from robust_ik.kernels.compiler.kernel_store import Store

Function = TypeVar("Function", bound=Callable[..., Any])

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}


def inlined(function: Function) -> Function:
    """A piece of kernels, compiled into each of them."""
    jitted: Function = numba.njit(inline="always", **OPTIONS)(function)
    return jitted


FLOAT, WHOLE = types.float64, types.int64


class HandleType(types.Type):
    """Any object, by its address: see `handles`."""

    def __init__(self) -> None:
        super().__init__(name="Handle")


HANDLE = HandleType()


def given(axes: int) -> Any:
    """The type of an array of doubles that is only read, C-contiguous."""
    return types.Array(FLOAT, axes, "C", readonly=True)


def filled(axes: int) -> Any:
    """The type of an array of doubles that is written to, C-contiguous."""
    return types.Array(FLOAT, axes, "C")


def kernel(*arguments: Any) -> Callable[[Function], Kernel]:
    """A function that Python calls, compiled when it is first needed for these types of arguments and for no others."""

    def made(function: Function) -> Kernel:
        KERNELS.append(Kernel(function, arguments))
        return KERNELS[-1]

    return made


class Kernel:
    """A function that is compiled, or read from disk, when it is first needed.

    Attributes:
        name: What it is called in its module.
        most: How many joints, rows and columns it is for at most, as its name says by _8 or _16; None for any number.
        arguments: The types of arguments it takes; others raise TypeError.
    """

    def __init__(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        self._function, self.name, self.arguments = function, function.__qualname__, arguments
        size = self.name.rpartition("_")[2]
        self.most = int(size) if size.isdigit() else None
        self._compiled: Callable[..., Any] | None = None

    @property
    def compiled(self) -> Callable[..., Any]:
        """What to call in a loop: nothing is checked or compiled any more. The same for every thread."""
        if self._compiled is None:
            with global_compiler_lock:  # Numba's own: with a second lock two threads might wait for each other
                if self._compiled is None:
                    self._compiled = compiled(self._function, self.arguments)
        return self._compiled

    def __call__(self, *arguments: Any) -> Any:
        """The function's result."""
        return self.compiled(*arguments)


KERNELS: list[Kernel] = []
"""All that modules imported so far have declared."""


def every_kernel() -> Sequence[Kernel]:
    """All that the modules below `robust_ik.kernels` declare, however deep they lie."""
    for module in pkgutil.walk_packages([str(Path(__file__).parents[1])], "robust_ik.kernels."):
        importlib.import_module(module.name)
    return tuple(KERNELS)


def compiled(function: Callable[..., Any], arguments: tuple[Any, ...]) -> Callable[..., Any]:
    """A dispatcher that knows these arguments and compiles no more; for handles what is behind it, without a choice.

    What takes handles is called one by one, for microseconds. It keeps Python's lock: to let it go takes time, and
    another thread that gets it may hold it for milliseconds.
    """
    brief = HANDLE in arguments
    dispatcher = numba.njit(**{**OPTIONS, "nogil": not brief})(function)
    _keep(dispatcher, function)
    dispatcher.compile(arguments)
    dispatcher.disable_compile()
    if brief:
        return dispatcher.overloads[arguments].entry_point  # type: ignore[no-any-return]
    return dispatcher  # type: ignore[no-any-return]


def _keep(made: Any, function: Callable[..., Any]) -> None:
    """Has a dispatcher look on disk before it compiles, unless there is no source, or one that does not say all."""
    with suppress(OSError):
        made._cache = Store(function)  # noqa: SLF001


def callback(function: Callable[..., Any], signature: Any) -> Any:
    """A function that compiled code calls by its address: a Numba CFunc, with `.address`, which must be held on to."""
    made = CFunc(function, (signature.args, signature.return_type), locals={}, options=dict(OPTIONS))
    _keep(made, function)
    made.compile()
    return made


def called(function: Function) -> Function:
    """A piece that is too large to be compiled into every place that calls it."""
    jitted: Function = numba.njit(**OPTIONS)(function)
    return jitted
