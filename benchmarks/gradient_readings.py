"""Measures what Almarkhi's and Maciejewski's search reaches, by every way to read what its paper leaves open.

`python -m benchmarks.gradient_readings` prints the table; with `--write` it goes into docs/singularities.md. Uniform
starts in [−π, π]ⁿ in groups, and the same ones moved by 1e-12: a range is over all groups of both. Some minutes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import track

import robust_ik as rik
from benchmarks.claims.spread import Spread
from benchmarks.tables import markdown, parser, publish
from robust_ik.checks import Array
from robust_ik.singularities.find.gradient_search import CLUSTER
from robust_ik.singularities.geometry.screw_chain import ScrewChain

SEARCHES = (("pa10", "PA-10", 2), ("pa10", "PA-10", 3), ("ur5", "UR5", 2))
"""Robot, its name in the table, corank: where the finder's table has least success."""
GROUPS, SIZE, MOVED = 2, 30, 1e-12
"""Groups of starts, starts in each, and how far they are moved, rad: chosen for some minutes in all."""
LONG: dict[str, Any] = {"patience": 50, "max_iterations": 600}
READINGS: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("none, eq. (10)", "grid", {"rotated": False}),
    ("none, eq. (10)", "exact", {"rotated": False, "line_search": "exact"}),
    ("2 %, the default", "grid", {}),
    ("0.01 %", "grid", {"cluster": 1e-4}),
    ("10 %", "grid", {"cluster": 0.1}),
    ("30 %", "grid", {"cluster": 0.3}),
    ("60 %", "grid", {"cluster": 0.6}),
    ("0.01 %", "exact", {"cluster": 1e-4, "line_search": "exact"}),
    ("2 %", "exact", {"line_search": "exact"}),
    ("10 %", "exact", {"cluster": 0.1, "line_search": "exact"}),
    ("30 %", "exact", {"cluster": 0.3, "line_search": "exact"}),
    ("2 %", "nearest", {"line_search": "nearest"}),
    ("2 %, shortest", "exact", {"line_search": "exact", "combination": "shortest"}),
    ("30 %, shortest", "exact", {"cluster": 0.3, "line_search": "exact", "combination": "shortest"}),
    ("2 %, three times as many steps", "exact", {"line_search": "exact", **LONG}),
)  # fmt: skip
"""Cluster tolerance, line search, and the parameters of `gradient_search` that they stand for."""
COLUMNS = (
    "clusters", "line search",
    *(f"{name}, corank {k}{what}" for _, name, k in SEARCHES for what in (": success", ", steps", ", σ apart")),
)  # fmt: skip


def starts(chain: ScrewChain) -> Array:
    """Groups of starts, and the same ones moved, (2 GROUPS, SIZE, n)."""
    rng = np.random.default_rng(1)
    begin = chain.random(rng, GROUPS * SIZE)
    moved = begin + MOVED * rng.standard_normal(begin.shape)
    return np.stack([begin, moved]).reshape(2 * GROUPS, SIZE, chain.n)


def measure(name: str, corank: int, options: dict[str, Any]) -> list[str]:
    """Success, median steps where it succeeds, and at how many of the other ends σ is no member of a cluster of 2 %."""
    chain = ScrewChain.of(rik.load(name))
    success, steps, apart = [], [], []
    for group in starts(chain):
        found = rik.gradient_search(chain, corank, group, **options)
        success.append(100 * float(found.converged.mean()))
        steps.extend(found.tries[found.converged])
        weakest = found.residual.weakest[~found.converged]
        apart.extend(weakest[:, 1] < (1 - CLUSTER) * weakest[:, 0])
    return [
        f"{Spread(tuple(success)):.0f} %",
        f"{np.median(steps):.0f}" if steps else "–",
        f"{100 * np.mean(apart):.0f} %" if apart else "–",
    ]


def main() -> None:
    arguments = parser(__doc__, "singularities.md").parse_args()
    rows = []
    for clusters, search, options in track(READINGS, console=Console(stderr=True), description="measuring"):
        cells = [cell for name, _, corank in SEARCHES for cell in measure(name, corank, options)]
        rows.append([clusters, search, *cells])
    publish(markdown(COLUMNS, rows), "singularities.md", "readings", write=arguments.write)


if __name__ == "__main__":
    main()
