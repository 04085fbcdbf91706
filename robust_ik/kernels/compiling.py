"""How a function is compiled: once for declared types, kept on disk where that is possible, never inside a loop."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba import types

Function = TypeVar("Function", bound=Callable[..., Any])

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}


def inlined(function: Function) -> Function:
    """A piece of kernels, compiled into each of them."""
    jitted: Function = numba.njit(inline="always", **OPTIONS)(function)
    return jitted


FLOAT, WHOLE = types.float64, types.int64


def given(axes: int) -> Any:
    """The type of an array of doubles that is only read, C-contiguous."""
    return types.Array(FLOAT, axes, "C", readonly=True)


def filled(axes: int) -> Any:
    """The type of an array of doubles that is written to, C-contiguous."""
    return types.Array(FLOAT, axes, "C")


def kernel(*arguments: Any) -> Callable[[Function], Kernel]:
    """A function that Python calls, compiled when it is first needed for these types of arguments and for no others."""
    return lambda function: Kernel(function, arguments)


class Kernel:
    """A function that is compiled, or read from the cache, when it is first needed.

    Attributes:
        arguments: The types of arguments it takes; others raise TypeError.
    """

    def __init__(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        self._function, self.arguments = function, arguments
        self._compiled: Callable[..., Any] | None = None

    @property
    def compiled(self) -> Callable[..., Any]:
        """What to call in a loop: nothing is checked or compiled any more."""
        if self._compiled is None:
            self._compiled = compiled(self._function, self.arguments)
        return self._compiled

    def __call__(self, *arguments: Any) -> Any:
        """The function's result."""
        return self.compiled(*arguments)


def compiled(function: Callable[..., Any], arguments: tuple[Any, ...]) -> Callable[..., Any]:
    """A dispatcher that knows these arguments and compiles no more."""
    dispatcher = cached(numba.njit, function)
    dispatcher.compile(arguments)
    dispatcher.disable_compile()
    return dispatcher  # type: ignore[no-any-return]


def cached(compiler: Callable[..., Any], function: Callable[..., Any], *arguments: Any) -> Any:
    """A compiler's result, with a cache on disk; without one where none can be written or the source is no file."""
    try:
        made = compiler(*arguments, cache=True, **OPTIONS)(function)
    except RuntimeError:
        return compiler(*arguments, **OPTIONS)(function)
    _stamp(made)
    return made


def _stamp(made: Any) -> None:
    """Ties what is cached to the source of all kernels: Numba looks only at the file of the function itself."""
    cache_file: Any = getattr(getattr(made, "_cache", None), "_cache_file", None)
    if hasattr(cache_file, "_source_stamp"):
        cache_file._source_stamp = (cache_file._source_stamp, _digest())


def _digest() -> str:
    sources = sorted(Path(__file__).parent.glob("*.py"))
    return hashlib.sha256(b"".join(source.read_bytes() for source in sources)).hexdigest()


def called(function: Function) -> Function:
    """A piece that is too large to be compiled into every place that calls it."""
    jitted: Function = numba.njit(**OPTIONS)(function)
    return jitted
