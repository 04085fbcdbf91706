"""Defines what is compiled: kernels for declared types, and the helpers that they call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numba
from numba import types

from robust_ik.kernels.compiler.object_files import HELPER, compiled
from robust_ik.kernels.compiler.python_entry import python_entry
from robust_ik.kernels.loader.kernel_store import Made, sources_of

Function = TypeVar("Function", bound=Callable[..., Any])


def inlined(function: Function) -> Function:
    """A helper that is compiled into each function that calls it."""
    jitted: Function = numba.njit(inline="always", **HELPER)(function)
    return jitted


def called(function: Function) -> Function:
    """A helper that is too large to be compiled into every function that calls it."""
    jitted: Function = numba.njit(**HELPER)(function)
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


@dataclass(frozen=True)
class Definition:
    """A function that is compiled for these types of arguments and for no others.

    Attributes:
        function: The Python function.
        arguments: FLOAT, WHOLE, HANDLE, `given` or `filled`; others raise TypeError.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...]

    def sources(self) -> bytes | None:
        """Hash of all that it is made of; None if no file determines it."""
        return sources_of(self.function, str(self.arguments))

    def made(self) -> Made:
        """Its machine code, entered by Python."""
        return compiled(self.function, self.arguments, python_entry)


def kernel(*arguments: Any) -> Callable[[Callable[..., Any]], Definition]:
    """Defines what a `Kernel` of the same name is compiled from."""
    return lambda function: Definition(function, arguments)
