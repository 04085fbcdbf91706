"""Measures the search for singular configurations: both methods, five robots, coranks 1 to 3.

`python -m benchmarks.singularity_finder` prints the table; with `--write` it goes into docs/singularities.md. Uniform
starts in [−π, π]ⁿ; ‖r‖ < 1e-11 σ₁ (for the gradient method σ < 1e-6, then polished to that); CPU time, the
failed starts' included: set OPENBLAS_NUM_THREADS=1.
"""

from __future__ import annotations

import time

import numpy as np
from rich.console import Console
from rich.progress import track

import robust_ik as rik
from benchmarks.tables import markdown, parser, publish
from robust_ik.singularities.find.find_points import Method, find_points
from robust_ik.singularities.geometry.screw_chain import ScrewChain

ROBOTS = {"pa10": "PA-10", "panda": "Panda", "puma560": "PUMA 560", "ur5": "UR5", "almarkhi_4dof": "Almarkhi's 4-DoF"}
CORANKS = (1, 2, 3)
STARTS: dict[Method, int] = {"projection": 1000, "gradient": 100}
COLUMNS = (
    "robot", "corank", "success", "median steps", "ms per point", "least ‖r‖/σ₁ of failures",
    "gradient: success", "… median steps", "… ms per point",
)  # fmt: skip


def measure(chain: ScrewChain, corank: int, method: Method) -> list[str]:
    """Success, median steps, milliseconds per point and the least residual of the starts that failed."""
    begin = time.process_time()
    found = find_points(chain, corank, STARTS[method], np.random.default_rng(1), method=method)
    took = 1e3 * (time.process_time() - begin)
    floor = f"{found.floors.min():.2g}" if found.failed else "–"
    if len(found) == 0:
        return ["none", "–", "–", floor]
    return [f"{100 * found.success:.1f} %", f"{np.median(found.iterations):.0f}", f"{took / len(found):.2f}", floor]


def row(name: str, corank: int) -> tuple[str, ...]:
    chain = ScrewChain.of(rik.load(name))
    find_points(chain, corank, 20, np.random.default_rng(0))  # the first call loads code
    return (
        ROBOTS[name],
        str(corank),
        *measure(chain, corank, "projection"),
        *measure(chain, corank, "gradient")[:3],
    )


def main() -> None:
    arguments = parser(__doc__, "singularities.md").parse_args()
    cases = [(name, corank) for name in ROBOTS for corank in CORANKS]
    rows = [row(*case) for case in track(cases, console=Console(stderr=True), description="measuring")]
    publish(markdown(COLUMNS, rows), "singularities.md", "finder", write=arguments.write)


if __name__ == "__main__":
    main()
