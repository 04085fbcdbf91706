"""Kernels that lie in the installed package, compiled by whoever built it for any processor of a level.

They serve the version of Python and the system that they were compiled for. Where Numba's settings are in the
environment they are left alone, since these ask for other code.

Source: the psABI for x86-64, "Micro-Architecture Levels", with LLVM's names of features.
"""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

from robust_ik.kernels.loader.target import SETTINGS, host, python

FOLDER = Path(__file__).parents[1] / "shipped"
"""Where they lie; there is no such folder unless they were built."""
FILE = FOLDER / "target"
"""Lines: what `target` says of the code, the level, and the versions of Python and the system that it serves."""
V2 = "cx16 popcnt sahf sse3 ssse3 sse4.1 sse4.2"
"""What level x86-64-v2 adds to the first 64-bit processors."""
LEVELS = {
    "x86-64-v3": frozenset(f"{V2} avx avx2 bmi bmi2 f16c fma lzcnt movbe xsave".split()),
    "generic": frozenset[str](),
}
"""The features that a processor must have, by LLVM's name of the level."""


def level() -> str:
    """The level that kernels are built for on this system; on another than x86-64, what all processors can do."""
    return "x86-64-v3" if host()[0].startswith("x86_64") else "generic"


def described(target: str) -> str:
    """What FILE says of code that `target` describes, which this process compiled for `level`."""
    return "\n".join((target, level(), python(), host()[0]))


@cache
def shipped() -> str | None:
    """What `target` said of the code that was shipped; None if there is none that serves here."""
    if any(name in os.environ for name in (*SETTINGS, "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")):
        return None
    try:
        made, of_level, *serves = FILE.read_text(encoding="utf-8").split("\n")
    except (OSError, ValueError):
        return None
    system, _, features = host()
    there = {each[1:] for each in features.split(",") if each.startswith("+")}
    fits = serves == [python(), system] and of_level in LEVELS and LEVELS[of_level] <= there
    return made if fits else None
