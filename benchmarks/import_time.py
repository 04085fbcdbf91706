"""Times `import robust_ik` and commands: what NumPy takes, what Pinocchio takes, and what is added by us and our needs.

`python -m benchmarks.import_time` prints the table; with `--write` it goes into docs/benchmarks.md, JSON beside it. A
process of its own each time, files in the system's cache. NumPy and Pinocchio are imported first, then robust_ik: what
is added is what a user of both pays. What the import puts off comes after: a robot by name, and all other public names.
Commands are whole processes, from the start of Python to its end. The split by `-X importtime` is of each module alone,
without its imports; the option itself slows them.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from collections import Counter

import numpy as np

from benchmarks.environments import UnavailableError, call, last_line, one_thread, progress
from benchmarks.report import Report, options
from benchmarks.rounds import spread

PROGRAM = """
import json, sys, time
def cost(job):
    cpu, wall = time.process_time(), time.perf_counter()
    job()
    return 1e3 * (time.process_time() - cpu), 1e3 * (time.perf_counter() - wall)
def imported(name):
    return cost(lambda: __import__(name))
times = {"numpy": imported("numpy"), "Pinocchio": imported("pinocchio"), "robust_ik, added": imported("robust_ik")}
numba, rik = "numba" in sys.modules, sys.modules["robust_ik"]
times["then load('panda')"] = cost(lambda: rik.load("panda"))
times["then every public name"] = cost(lambda: [getattr(rik, name) for name in rik.__all__])
print(json.dumps({**times, "numba": numba}))
"""
COMMANDS = ("--help", "robots")
SPLIT = "import numpy, pinocchio; import robust_ik"
GROUPS = {
    "numpy": "numpy", "pinocchio": "Pinocchio", "eigenpy": "Pinocchio", "coal": "Pinocchio", "hppfcl": "Pinocchio",
    "cmeel": "Pinocchio", "robust_ik": "our own modules",
}  # fmt: skip
COLUMNS = ("what", "CPU [ms]", "q1 to q3", "wall [ms]")


def measure(rounds: int) -> tuple[dict[str, np.ndarray], bool]:
    """Milliseconds (rounds, 2), CPU and wall, by part; whether numba was imported."""
    found = []
    for number in range(rounds + 1):
        progress.print(f"round {number} of {rounds}")
        found.append(json.loads(call([sys.executable, "-c", PROGRAM])))
        found[-1] |= {f"robust-ik {each}": command(each) for each in COMMANDS}
    parts = [key for key in found[0] if key != "numba"]
    # The first round reads files that are not in the system's cache yet.
    return {part: np.array([each[part] for each in found[1:]]) for part in parts}, found[-1]["numba"]


def command(arguments: str) -> tuple[float, float]:
    """Milliseconds, CPU and wall, of the command with these arguments."""
    program = "from robust_ik.cli import main; main()"
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    call([sys.executable, "-c", program, *arguments.split()])
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return 1e3 * cpu, 1e3 * wall


def split() -> dict[str, float]:
    """Milliseconds of each group's modules alone, and of the ten slowest of what is neither, by `-X importtime`."""
    command = [sys.executable, "-X", "importtime", "-c", SPLIT]
    done = subprocess.run(command, env=one_thread(), capture_output=True, text=True, check=False)
    if done.returncode:
        raise UnavailableError(last_line(done.stderr))
    groups: Counter[str] = Counter()
    for line in done.stderr.splitlines():
        own, _, name = line.removeprefix("import time:").split("|")
        if own.strip().isdigit():
            package = name.strip().split(".")[0]
            library = "the standard library" if package in sys.stdlib_module_names else package
            groups[GROUPS.get(package, library)] += int(own)
    return {name: 1e-3 * us for name, us in groups.most_common(10)}


def main() -> None:
    arguments = options(__doc__).parse_args()
    parts, numba = measure(arguments.rounds)
    rows, results = [], {}
    for part, ms in parts.items():
        results[part] = {"cpu_ms": spread(ms[:, 0]), "wall_ms": spread(ms[:, 1])}
        low, middle, high = spread(ms[:, 0]).values()
        rows.append((part, f"{middle:.0f}", f"{low:.0f} to {high:.0f}", f"{np.median(ms[:, 1]):.0f}"))
    results["numba is imported"], results["split, ms"] = numba, split()
    rows.append(("numba is imported", "yes" if numba else "no", "–", "–"))
    rows += [(f"… {name}, modules alone", "–", "–", f"{ms:.0f}") for name, ms in results["split, ms"].items()]
    Report("import_time", COLUMNS, rows, results, {"rounds": arguments.rounds}).publish(write=arguments.write)


if __name__ == "__main__":
    main()
