"""find_singularities: the atlas of a robot."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from typing import TYPE_CHECKING

import numpy as np

from robust_ik.checks import checked_parameter
from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError
from robust_ik.runtime.parallel import seed_of
from robust_ik.runtime.progress import ProgressCallback
from robust_ik.singularities.atlas.atlas import SingularityAtlas, atlas_of
from robust_ik.singularities.atlas.atlas_record import Settings
from robust_ik.singularities.atlas.search_run import searched
from robust_ik.singularities.atlas.search_state import SearchState
from robust_ik.singularities.conditions.robot_facts import RobotFacts
from robust_ik.singularities.find.find_points import Method
from robust_ik.singularities.find.projection_search import TOLERANCE
from robust_ik.singularities.find.rank_residual import check_corank

if TYPE_CHECKING:
    from robust_ik.description.dh import DHTable
    from robust_ik.robot.robot import Robot

STARTS = 1500
"""Random starts for a corank. Chosen: three pieces of work (`CHUNK`); more find rarer families, but take longer."""
DEFAULT_SEED = 0
"""Default seed of the random starts: any number, always the same."""


@checked
def find_singularities(
    robot: Robot,
    corank: int | None = None,
    *,
    starts: int = STARTS,
    rng: np.random.Generator | int | None = None,
    rows: Sequence[str] | None = None,
    length_scale: float | None = None,
    tolerance: float = TOLERANCE,
    method: Method = "projection",
    table: DHTable | None = None,
    snap: bool = False,
    certify: bool = True,
    executor: Executor | None = None,
    progress: ProgressCallback | None = None,
) -> SingularityAtlas:
    """Finds every family of singular configurations, of every corank, that random starts reach, within limits or not.

    Args:
        robot: An arm with a tip.
        corank: Only this one; by default all up to the last that exists.
        starts: Random starts for each corank.
        rng: A seed, or a generator to draw one from; by default always the same.
        rows: Task rows, of x y z wx wy wz; default the robot's. The corank is the largest rank that the arm has in them
            anywhere, less the rank at a configuration; the atlas says if that is not the number of rows.
        length_scale: Length by which linear rows are divided where σ is told, m; default the robot's. Strata do not
            depend on it.
        tolerance: ‖r‖/σ₁ that counts as zero, r being the k smallest singular values.
        method: "projection" (Levenberg-Marquardt), or "gradient", the paper's own, for comparison.
        table: DH table whose lengths name coefficients; by default the table of a robot of the catalogue.
        snap: Whether the geometry with nearly exact angles made exact is the intended one. It is analysed in any case;
            without `snap` the atlas also gives the least σ of the model as given.
        certify: Whether to try exact proofs that the lists are complete, with a bounded effort.
        executor: An executor that runs the pieces, any `concurrent.futures.Executor`; by default this process. The
            atlas is the same to the last bit.
        progress: Called with (steps done, steps in all).

    Returns:
        The atlas. After Ctrl-C, the atlas of what was found, marked as interrupted; a second Ctrl-C while its rows are
        made leaves out unfinished ones.

    Raises:
        TipError: The robot was loaded whole, without a tip.
        InputError: The robot cannot have this corank, or a parameter is out of range.
    """
    facts = RobotFacts.of(robot, rows, length_scale, table, snap)
    if isinstance(starts, bool) or not isinstance(starts, (int, np.integer)) or starts < 1:
        raise InputError(f"starts must be a whole number of at least 1, got {starts!r}")
    if corank is not None:
        check_corank(facts.chain, corank)
        corank = int(corank)
    tolerance = checked_parameter("tolerance", tolerance, above=0, below=1e-6)
    if not isinstance(method, str):
        raise InputError(f"method must be 'projection' or 'gradient', got {method!r}")
    settings = Settings(corank, seed_of(rng, DEFAULT_SEED), int(starts), tolerance, method, bool(certify))
    state = SearchState(facts.measured_in(facts.units), settings, executor=executor)
    return atlas_of(searched(state, int(starts), progress))
