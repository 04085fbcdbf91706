"""Gain formulas as compiled functions that kernels call by address."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable
from typing import Any

from robust_ik.kernels.loader.kernel_store import Made, NotCompilableError, name_of, obtained, sources_of
from robust_ik.kernels.loader.machine_code import load

TYPES = "a gain formula"
"""Names the types of a formula's arguments, which `formula_compiling` states, in the hash of its sources."""

_addresses: dict[Callable[..., Any], int | None] = {}
"""Addresses of compiled formulas; None for a formula that cannot be compiled."""
_lock = threading.Lock()


def address_of(formula: Callable[..., Any]) -> int | None:
    """The address of the compiled formula; None, with a warning that says why, if it cannot be compiled.

    It is compiled once, in this process or in an earlier one.
    """
    with _lock:  # a second thread must not compile it as well
        if formula not in _addresses:
            _addresses[formula] = _obtained(formula)
    return _addresses[formula]


def _obtained(formula: Callable[..., Any]) -> int | None:
    try:
        return obtained(name_of(formula), sources_of(formula, TYPES), load, lambda: _made(formula))
    except NotCompilableError as error:
        warnings.warn(f"{formula.__qualname__} cannot be compiled and stays Python: {error}", stacklevel=4)
        return None


def _made(formula: Callable[..., Any]) -> Made:
    from robust_ik.kernels.compiler.formula_compiling import made

    return made(formula)
