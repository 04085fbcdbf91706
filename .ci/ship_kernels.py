"""Compiles every kernel for a level of processors, for a wheel that needs no compiling: `make wheel-with-kernels`.

Usage: ship_kernels.py FOLDER. The folder then holds what goes to `robust_ik/kernels/shipped` in the wheel.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from robust_ik.kernels.loader.shipped import FILE, described, level
from robust_ik.kernels.loader.target import SETTINGS, target


def main(folder: Path) -> None:
    """Compiles them all into the folder."""
    for name in SETTINGS:
        os.environ.pop(name, None)
    os.environ |= {"NUMBA_CPU_NAME": level(), "NUMBA_CPU_FEATURES": "", "NUMBA_CACHE_DIR": str(folder / "compiled")}
    import robust_ik as rik  # Numba reads the settings when it is imported

    seconds = rik.warmup(progress=lambda done, count: print(f"\r{done} of {count} for {level()}", end="", flush=True))
    for file in (folder / "compiled" / "robust_ik").iterdir():
        shutil.move(file, folder / file.name)
    shutil.rmtree(folder / "compiled")
    (folder / FILE.name).write_text(described(target()), encoding="utf-8")
    print(f", in {seconds:.0f} s")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
