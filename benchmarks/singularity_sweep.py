"""Sweeps the search for singularities over every distinct arm of 6 or 7 joints, and checks every row that it finds.

`python -m benchmarks.singularity_sweep` prints the table; with `--write` it goes into docs/singularities.md. The arms
are the chains of 6 or 7 independent joints of example-robot-data, of those that are alike or mirrored the first one,
and those of robots/ with any number of joints. Default settings; CPU time of one core. A row is spurious where its
members, free joints anywhere, are not singular by Pinocchio's Jacobian, or still are with a pinned joint moved away.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track

import robust_ik as rik
from benchmarks.tables import markdown, parser, publish
from robust_ik.description.catalog import EXAMPLES, Entry, catalog
from robust_ik.description.urdf.urdf_reader import read_urdf
from robust_ik.kinematics.svd import svd
from robust_ik.singularities.atlas.atlas import SingularityAtlas
from robust_ik.singularities.atlas.evidence import Completeness
from robust_ik.singularities.families.stratum import Stratum
from robust_ik.singularities.geometry.screw_chain import axes_at_zero, constants

JOINTS = (6, 7)
COLUMNS = (
    "robot", "tip", "joints", "rows / pieces by corank", "spurious rows", "unexplained", "unmatched of fresh",
    "certified coranks", "CPU s",
)  # fmt: skip
MEMBERS = 20
SINGULAR, REGULAR = 1e-9, 1e-6
"""σ_{m−k+1}/σ₁ of a member, at most, and where a condition is broken, at least."""
ROUNDED = 50
"""A model whose angles are rounded comes as near as so many times what its row tells."""


@dataclass(frozen=True)
class Case:
    """One arm: a name of the catalogue and a tip, None for the default one."""

    name: str
    tip: str | None

    def load(self) -> rik.Robot:
        """The robot of its catalogue name, cut to the tip."""
        return rik.load(self.name, self.tip)


def cases(names: Sequence[str] = ()) -> Iterator[Case]:
    """Every distinct arm; only those of some robots if names are given."""
    known: list[NDArray[np.float64]] = []
    for entry in sorted(catalog().values(), key=_plain_first):
        if names and entry.name not in names:
            continue
        for case in _of(entry):
            form = geometry(case.load())
            if not any(form.shape == other.shape and np.allclose(form, other, atol=1e-5) for other in known):
                known.append(form)
                yield case


def _plain_first(entry: Entry) -> tuple[bool, bool, int, str]:
    """Ours, then those with a documented tool, then those with the shortest names: no gripper, no special limits."""
    return entry.source == EXAMPLES, entry.known is None, len(entry.name), entry.name


def _of(entry: Entry) -> list[Case]:
    """The arms of one robot: that to its known tip, those to its leaves, or its only one."""
    if entry.source != EXAMPLES:
        return [Case(entry.name, None)]
    tree = read_urdf(entry.path)
    tips = [*([entry.known.tip] if entry.known else []), *tree.leaves]
    return [Case(entry.name, tip) for tip in tips if len(tree.moving_joints(tip)) in JOINTS]


def geometry(robot: rik.Robot) -> NDArray[np.float64]:
    """How far and how steep each axis stands to each other one at zero, the same for a mirrored arm, (3 c c,)."""
    frames, sliding, mixing = constants(robot)
    axes, points = axes_at_zero(frames[:-1, :3, :3], frames[:-1, :3, 3])
    cosines = np.abs(axes @ axes.T)
    normals = np.cross(axes[:, None], axes[None])
    apart = points[:, None] - points[None]
    across = np.einsum("ijk,ijk->ij", apart, normals) / np.maximum(np.linalg.norm(normals, axis=2), 1e-9)
    parallel = np.linalg.norm(np.cross(apart, axes[:, None]), axis=2)
    distances = np.where(cosines > 1 - 1e-9, parallel, np.abs(across))
    distances *= np.outer(~sliding, ~sliding)
    return np.concatenate([cosines.ravel(), distances.ravel(), np.abs(mixing).ravel(), sliding.astype(float)])


def spurious(robot: rik.Robot, atlas: SingularityAtlas) -> int:
    """How many rows are none by the robot's own Jacobian."""
    rng = np.random.default_rng(7)
    return sum(not _is_sound(robot, atlas, row, rng) for row in atlas)


def _is_sound(robot: rik.Robot, atlas: SingularityAtlas, row: Stratum, rng: np.random.Generator) -> bool:
    bound = sorted({joint for each in row.conditions for joint in each.angle.joints} | set(_coupled(row)))
    for leaf in row.leaves:
        members = leaf.filled(atlas.robot.chain, rng, MEMBERS)
        if _last(robot, atlas, members, row.corank).max() > max(SINGULAR, ROUNDED * row.off):
            return False
        away = members + rng.uniform(0.3, 1.0, (len(bound), MEMBERS, 1)) * np.eye(robot.n)[bound][:, None]
        if any(np.median(_last(robot, atlas, moved, row.corank)) < REGULAR for moved in away):
            return False
    return True


def _coupled(row: Stratum) -> tuple[int, ...]:
    return (*row.curve, *(joint for relation in row.relations for joint in relation.joints))


def _last(robot: rik.Robot, atlas: SingularityAtlas, values: NDArray[np.float64], corank: int) -> NDArray[np.float64]:
    """σ_{g−k+1}/σ₁ by Pinocchio, not by the chain that the atlas was made with, (N,)."""
    chain = atlas.robot.chain
    s = svd(robot.jacobian(robot.configuration(values), rows=chain.rows)).s
    return np.asarray(s[:, chain.full_rank - corank] / s[:, 0])


def measure(case: Case) -> tuple[str, ...]:
    """The line of one arm."""
    robot = case.load()
    begin = time.process_time()
    atlas = rik.find_singularities(robot)
    took = time.process_time() - begin
    counts = [
        f"{len(rows)} / {sum(row.components for row in rows)}"
        for rows in (atlas.of_corank(corank) for corank in range(1, atlas.highest + 1))
    ]
    unexplained = sum(each.unexplained for each in atlas.evidence)
    unmatched, fresh = sum(each.unmatched for each in atlas.evidence), sum(each.fresh for each in atlas.evidence)
    return (
        case.name, str(robot.tip), str(robot.n), ", ".join(counts) or "none", str(spurious(robot, atlas)),
        str(unexplained), f"{unmatched} of {fresh}", _certified(atlas), f"{took:.1f}",
    )  # fmt: skip


def _certified(atlas: SingularityAtlas) -> str:
    """The coranks whose list is proved to be complete, of all that were looked for."""
    proved = [str(each.corank) for each in atlas.evidence if each.status is Completeness.CERTIFIED]
    return "all" if len(proved) == len(atlas.evidence) else " ".join(proved) or "none"


def sweep(chosen: Sequence[Case], jobs: int) -> list[tuple[str, ...]]:
    """The lines of all arms, in order; progress on stderr."""
    # One thread each, set before the workers load NumPy: CPU time then is what one core needs.
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    console = Console(stderr=True)
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        futures = {pool.submit(measure, case): case for case in chosen}
        for future in track(as_completed(futures), "sweeping", len(futures), console=console):
            console.print(" ".join(future.result()))
    return [future.result() for future in futures]


def main() -> None:
    arguments = parser(__doc__, "singularities.md")
    arguments.add_argument("--jobs", type=int, default=1, help="arms that are searched at the same time")
    arguments.add_argument("--names", nargs="*", default=(), help="only these robots of the catalogue")
    chosen = arguments.parse_args()
    lines = sweep(list(cases(chosen.names)), chosen.jobs)
    publish(markdown(COLUMNS, lines), "singularities.md", "sweep", write=chosen.write)


if __name__ == "__main__":
    main()
