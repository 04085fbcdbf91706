"""What machine code depends on besides its sources: Python, Numba and its settings, and the processor.

All of it is known without importing Numba. Settings are those of the environment, as Numba reads them.
"""

from __future__ import annotations

import os
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path

SETTINGS = (
    "NUMBA_OPT",
    "NUMBA_LOOP_VECTORIZE",
    "NUMBA_SLP_VECTORIZE",
    "NUMBA_BOUNDSCHECK",
    "NUMBA_DEBUGINFO",
    "NUMBA_ENABLE_PROFILING",
    "NUMBA_ENABLE_AVX",
)
"""Numba's environment variables that change the machine code, besides those that name the processor."""
FILE = ".numba_config.yaml"
"""Numba reads settings from this file too, in the folder where the program runs."""


def target() -> str:
    """All of it, as text."""
    settings = [os.environ.get(name) for name in SETTINGS]
    return repr((python(), *_compiler(), *processor(), settings, _read(Path(FILE))))


def python() -> str:
    """The version and the build of Python, whose objects compiled code reads."""
    return f"{sys.implementation.cache_tag} {getattr(sys, 'abiflags', '')}"


def processor() -> tuple[str, str, str]:
    """The system, the processor's name and its features, or those that NUMBA_CPU_NAME and NUMBA_CPU_FEATURES name."""
    system, name, features = host()
    named, with_features = os.environ.get("NUMBA_CPU_NAME"), os.environ.get("NUMBA_CPU_FEATURES")
    if with_features is None:
        with_features = "" if named is not None and named.lower() == "generic" else features
    return system, name if named is None else named, with_features


@cache
def host() -> tuple[str, str, str]:
    """The system, the name of this machine's processor, and its features as LLVM lists them: "+avx,-avx512f"."""
    import llvmlite.binding as llvm

    try:
        features = llvm.get_host_cpu_features().flatten()
    except RuntimeError:  # LLVM knows none of this processor, and Numba then names none
        features = ""
    return llvm.get_process_triple(), llvm.get_host_cpu_name(), features


@cache
def _compiler() -> tuple[str, str]:
    """The versions of LLVM's binding and of Numba, by its file that holds it: package metadata is slow to read."""
    import llvmlite

    found = find_spec("numba")
    return llvmlite.__version__, _read(Path(found.origin).with_name("_version.py")) if found and found.origin else ""


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
