"""Measures how long each kernel takes to compile: `python -m benchmarks.compile_time`.

With `--write` the table goes into docs/speed.md. Every kernel is compiled anew, in a folder of its own that is thrown
away, in one process: CPU seconds, which other work on the machine changes little. A second process then reads all of
them from disk. `robust_ik/kernels/loader/announcing.py` holds these seconds, rounded, for what is said before a
kernel is compiled; where one differs from it by more than a half, this says so.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile

from benchmarks.tables import markdown, parser, publish
from robust_ik.kernels.loader.announcing import SECONDS, WHAT

PROGRAM = """
import json, logging, pathlib, sys, time
logging.getLogger("robust_ik").setLevel(logging.ERROR)
from robust_ik.kernels.loader import kernel_store
kernel_store.places = lambda: iter([pathlib.Path(sys.argv[1])])  # nowhere else, where they may lie already
from robust_ik.inverses import CLASSES, GainFormula
from robust_ik.kernels.loader.kernel import every_kernel
from robust_ik.kernels.compiler.gain_callbacks import address_of
times = {}
for kernel in every_kernel():
    began = time.process_time()
    kernel.compiled
    times[kernel.full_name] = time.process_time() - began
began = time.process_time()
for each in CLASSES:
    if issubclass(each, GainFormula):
        address_of(each.formula)
times["formulas of gains"] = time.process_time() - began
times["in all, with imports"] = time.process_time()
print(json.dumps(times))
"""
COLUMNS = ("for", "kernels", "compiled [s]", "read from disk [s]")


def measure(folder: str) -> dict[str, float]:
    """CPU seconds by kernel in a new process that keeps kernels in this folder."""
    done = subprocess.run([sys.executable, "-c", PROGRAM, folder], capture_output=True, text=True, check=True)
    times: dict[str, float] = json.loads(done.stdout)
    return times


def rows(compiled: dict[str, float], read: dict[str, float]) -> list[tuple[str, ...]]:
    """One for each thing that kernels are for, then the gains, then the sums."""
    made = []
    for module, what in WHAT.items():
        names = [name for name in compiled if name.startswith(f"{module}.")]
        each = ", ".join(f"`{name.partition('.')[2]}` {compiled[name]:.0f}" for name in names)
        made.append((what, each, *(f"{sum(times[name] for name in names):.1f}" for times in (compiled, read))))
    rest = [name for name in compiled if "." not in name]
    return made + [(name, "", f"{compiled[name]:.1f}", f"{read[name]:.1f}") for name in rest]


def main() -> None:
    arguments = parser(__doc__, "speed.md").parse_args()
    with tempfile.TemporaryDirectory() as folder:
        compiled, read = measure(folder), measure(folder)
    publish(markdown(COLUMNS, rows(compiled, read)), "speed.md", "compile_time", write=arguments.write)
    for name, stated in SECONDS.items():
        if abs(compiled[name] - stated) > 0.5 * max(stated, 1):
            print(f"announcing.py says {stated} s of {name}, which took {compiled[name]:.1f}", file=sys.stderr)


if __name__ == "__main__":
    main()
