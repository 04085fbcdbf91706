"""Kernels: functions of compiled code, by the names of the Python functions that they are compiled from."""

from __future__ import annotations

import importlib
import pkgutil
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

KERNELS: list[Kernel] = []
"""All kernels of the packages imported so far."""
_lock = threading.RLock()


class Kernel:
    """A function that is read from disk, or compiled, at its first use.

    Attributes:
        module: The module whose functions it is compiled from; it is imported only to compile.
        name: Its name there, where `compiling.kernel` defines it.
        most: Most joints, rows and columns it can handle, from the ending _8 or _16 of its name; None for any number.
    """

    def __init__(self, module: str, name: str) -> None:
        self.module, self.name = module, name
        size = self.name.rpartition("_")[2]
        self.most = int(size) if size.isdigit() else None
        self._compiled: Callable[..., Any] | None = None

    @property
    def compiled(self) -> Callable[..., Any]:
        """The compiled function, without this object around it. The same for every thread."""
        if self._compiled is None:
            with _lock:
                if self._compiled is None:
                    self._compiled = self._obtained()
        return self._compiled

    @property
    def full_name(self) -> str:
        """The module, without its packages, and the name."""
        return f"{self.module.rpartition('.')[2]}.{self.name}"

    @property
    def definition(self) -> Any:
        """The `compiling.Definition` that it is compiled from."""
        return getattr(importlib.import_module(self.module), self.name)

    def __call__(self, *arguments: Any) -> Any:
        """The function's result.

        Raises:
            TypeError: The arguments are not of the types that it was compiled for.
        """
        return self.compiled(*arguments)

    def _obtained(self) -> Callable[..., Any]:
        from robust_ik.kernels.loader.kernel_store import SOURCES, obtained

        ours = self.module.startswith("robust_ik.kernels.")
        sources = SOURCES if ours else self.definition.sources()
        return obtained(self.full_name, sources, self._loaded, lambda: self.definition.made())

    def _loaded(self, content: bytes) -> Callable[..., Any]:
        from robust_ik.kernels.loader.machine_code import function_at, load

        return function_at(load(content), self.name)


def kernels(module: str, *names: str) -> tuple[Kernel, ...]:
    """Kernels that a module defines."""
    made = tuple(Kernel(module, name) for name in names)
    KERNELS.extend(made)
    return made


def every_kernel() -> Sequence[Kernel]:
    """All kernels that the rooms of `robust_ik.kernels` name."""
    for room in pkgutil.iter_modules([str(Path(__file__).parents[1])], "robust_ik.kernels."):
        importlib.import_module(room.name)
    return tuple(KERNELS)
