"""The tests as if on other machines, one setting after the other, and a table: `make test-everywhere`.

Each setting moves last bits, or the load: other routines of BLAS, of NumPy and of the C library, compiled code for
another processor, starts a little aside, cores that are busy. What is true of a method passes under all of them. What a
setting does is tried first: one that this processor cannot run, or that changes nothing on it, is left out with a word.
"""

import argparse
import os
import re
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tests.conftest import MOVED_STARTS

ROOT = Path(__file__).parent.parent
BITS = """
import hashlib, math, numpy as np
x = np.arange(1, 5000) * 0.01237
A = np.random.default_rng(0).normal(size=(60, 60))
parts = {
    "blas": [A @ A, np.linalg.svd(A)[1]],
    "numpy": [f(x) for f in (np.sin, np.cos, np.exp, np.tanh)],
    "libm": [np.array([f(v) for v in x for f in (math.sin, math.cos, math.exp)])],
}
print(*(name + hashlib.sha256(b"".join(each.tobytes() for each in part)).hexdigest() for name, part in parts.items()))
"""
"""A program that prints what BLAS, NumPy and the C library make of the same numbers."""
DISPATCHED = """
from numpy._core import _multiarray_umath as found
print(*(name for name in found.__cpu_dispatch__ if found.__cpu_features__[name]))
"""
PROCESSOR = "import llvmlite.binding as llvm; print(llvm.get_host_cpu_name())"
KERNELS = ("Prescott", "Haswell", "Sandybridge", "SkylakeX", "ARMV8", "NEOVERSEN1")
"""Of OpenBLAS, oldest first; of these the first two that differ from what this machine takes, and from each other."""
PLAIN_LIBM = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4"}


@dataclass(frozen=True)
class Setting:
    """What is different.

    Attributes:
        name: In words.
        variables: Of the environment.
        part: Which line of BITS must differ from the default; None if no line tells.
        busy: Whether as many programs as there are cores keep them busy meanwhile.
        missing: Why it cannot be tried here; empty if it can.
    """

    name: str
    variables: dict[str, str] = field(default_factory=dict)
    part: str | None = None
    busy: bool = False
    missing: str = ""


def answer(program: str, variables: dict[str, str] | None = None) -> list[str]:
    """The words that a Python program prints in an environment; none if it fails there or warns."""
    environment = os.environ | (variables or {})
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", program], env=environment, capture_output=True, text=True
    )
    return run.stdout.split() if run.returncode == 0 and "not found" not in run.stderr else []


def settings() -> list[Setting]:
    """All of them as far as this machine goes, the default first and the most different one second."""
    bits = dict(zip(("blas", "numpy", "libm"), answer(BITS)))
    first, second = kernels(bits["blas"])
    simd = {"NPY_DISABLE_CPU_FEATURES": " ".join(answer(DISPATCHED))}
    plain = compiled_for_any()
    old = first.variables | simd | PLAIN_LIBM | plain.variables | {MOVED_STARTS: "1e-12"}
    every = [
        Setting("as it is"),
        Setting("an old machine: of BLAS, NumPy, C library and compiled code the plainest; moved starts", old, "blas"),
        first,
        second,
        Setting("NumPy without SIMD", simd, "numpy"),
        Setting("C library without FMA", PLAIN_LIBM, "libm"),
        plain,
        Setting("starts moved by 1e-12", {MOVED_STARTS: "1e-12"}),
        Setting("load on all cores", busy=True),
    ]
    return [tried(each, bits) for each in every]


def kernels(usual: str) -> list[Setting]:
    """Two settings of BLAS with kernels unlike the usual one and each other, one with one thread, one with two."""
    seen, found = {usual}, []
    for kernel in KERNELS:
        bits = answer(BITS, {"OPENBLAS_CORETYPE": kernel})
        if bits and bits[0] not in seen:
            seen.add(bits[0])
            found.append(kernel)
    made = []
    for threads in (1, 2):
        variables = {"OPENBLAS_NUM_THREADS": str(threads)}
        if threads > len(found):
            made.append(
                Setting(f"BLAS kernel {threads}", variables, missing="no such kernel of BLAS on this processor")
            )
            continue
        variables["OPENBLAS_CORETYPE"] = found[threads - 1]
        words = "1 thread" if threads == 1 else f"{threads} threads"
        made.append(Setting(f"BLAS kernel {found[threads - 1]}, {words}", variables, "blas"))
    return made


def compiled_for_any() -> Setting:
    """Kernels that run on every processor of the family; they are compiled anew the first time, about two minutes."""
    here = answer(PROCESSOR)
    missing = "this processor is the generic one already" if here == ["generic"] else ""
    return Setting("compiled for any processor", {"NUMBA_CPU_NAME": "generic"}, missing=missing)


def tried(setting: Setting, usual: dict[str, str]) -> Setting:
    """The setting, with the reason if it cannot be tried here."""
    missing = setting.missing
    if not missing and setting.part is not None:
        bits = answer(BITS, setting.variables)
        if not bits:
            missing = "this machine cannot run it"
        elif bits[list(usual).index(setting.part)] == usual[setting.part]:
            missing = "it changes nothing on this machine"
    return Setting(setting.name, setting.variables, setting.part, setting.busy, missing)


@contextmanager
def load(wanted: bool):
    """Keeps as many programs running as there are cores."""
    count = os.cpu_count() or 1 if wanted else 0
    programs = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for program in programs:
            program.kill()
            program.wait()


def run(setting: Setting, arguments: list[str], folder: Path) -> tuple[bool, str]:
    """Whether all tests pass under the setting, and pytest's last line; all that pytest says goes to a file."""
    name = re.sub(r"\W+", "_", setting.name)[:40].strip("_")
    with ExitStack() as stack:
        stack.enter_context(load(setting.busy))
        log = stack.enter_context((folder / f"{name}.log").open("w", encoding="utf-8"))
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-rfE", *arguments]
        code = subprocess.run(command, env=os.environ | setting.variables, stdout=log, stderr=log, cwd=ROOT).returncode
    lines = (folder / f"{name}.log").read_text(encoding="utf-8").splitlines()
    for line in lines:
        if line.startswith(("FAILED", "ERROR")):
            print(f"    {line}")
    return code == 0, next((line for line in reversed(lines) if " in " in line), f"pytest ended with {code}").strip(
        "= "
    )


def chosen(every: list[Setting], words: list[str]) -> list[Setting]:
    """Those whose names hold one of the words."""
    found = [each for each in every if not words or any(word in each.name for word in words)]
    if not found:
        raise SystemExit(
            f"no setting is called {', '.join(words)}; there are: {'; '.join(each.name for each in every)}"
        )
    return found


def main(arguments: list[str] | None = None) -> int:
    """Runs and prints; 1 if anything failed, or nothing could be tried."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], epilog="What is left over is for pytest.")
    parser.add_argument("--only", action="append", default=[], metavar="WORD", help="settings with this in their name")
    parser.add_argument("--list", action="store_true", help="the settings, and what they set; nothing is run")
    parser.add_argument("--logs", type=Path, default=ROOT / "out" / "everywhere", help="a folder for what pytest says")
    given, rest = parser.parse_known_args(arguments)
    table, failed, ran = Table("setting", "outcome", "tests", "seconds"), False, 0
    given.logs.mkdir(parents=True, exist_ok=True)
    for setting in chosen(settings(), given.only):
        if given.list or setting.missing:
            table.add_row(setting.name, setting.missing or " ".join(f"{k}={v!r}" for k, v in setting.variables.items()))
            continue
        print(f"{setting.name} …", flush=True)
        started = time.monotonic()
        passed, line = run(setting, rest or ["-n", "auto", "--dist", "loadfile"], given.logs)
        failed, ran = failed or not passed, ran + 1
        table.add_row(setting.name, "passed" if passed else "FAILED", line, f"{time.monotonic() - started:.0f}")
    Console(width=150).print(table)
    return 0 if given.list or (ran and not failed) else 1


if __name__ == "__main__":
    sys.exit(main())
