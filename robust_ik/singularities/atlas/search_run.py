"""Runs one search from its first start to its rows; a continued search runs the same code."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from robust_ik.certificates import Certificate
from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError
from robust_ik.runtime.parallel import parts
from robust_ik.runtime.progress import Told
from robust_ik.singularities.atlas.atlas_record import AtlasRecord
from robust_ik.singularities.atlas.corank_search import (
    begin,
    hold_out,
    judged,
    read_corank,
    say_what_is_left,
    unjudged,
)
from robust_ik.singularities.atlas.search_pieces import CHUNK
from robust_ik.singularities.atlas.search_state import SearchState, Tally, work_of
from robust_ik.singularities.families.stratum import Stratum
from robust_ik.singularities.families.stratum_rows import make_rows


@checked
def extend(
    atlas: AtlasRecord, starts: int, executor: Executor | None = None, progress: Told | None = None
) -> AtlasRecord:
    """An atlas after further starts for each corank; see `SingularityAtlas.extended`."""
    if isinstance(starts, bool) or not isinstance(starts, (int, np.integer)) or starts < 1:
        raise InputError(f"starts must be a whole number of at least 1, got {starts!r}")
    work = work_of(atlas)
    work.settings = replace(atlas.settings, starts=atlas.settings.starts + int(starts))
    work.executor = executor
    return searched(work, int(starts), progress)


def searched(work: SearchState, starts: int, progress: Told | None) -> AtlasRecord:
    """The record after these starts for each corank, or after Ctrl-C."""
    interrupted = False
    try:
        _search(work, starts, progress)
    except KeyboardInterrupt:
        interrupted = True
        say_what_is_left(work, _wanted(work))
    strata: list[Stratum] = []
    try:
        for made in make_rows(work.facts, work.leaves, work.rng(0, 9)):
            strata += made
        evidence = judged(work)
    except KeyboardInterrupt:
        interrupted, evidence = True, unjudged(work)
    proofs = tuple(work.proven[k].proof for k in sorted(work.proven))
    return AtlasRecord(
        work.facts, tuple(strata), evidence, work.settings, interrupted, Certificate(proofs) if proofs else None
    )


def _wanted(work: SearchState) -> list[int]:
    """The coranks to look for; the search stops at the first one that does not exist."""
    return [work.settings.corank] if work.settings.corank else list(range(1, work.facts.chain.m + 1))


def _search(work: SearchState, starts: int, progress: Told | None) -> None:
    """Runs the search step by step: each corank is searched, proved if possible and read; then all have a hold-out."""
    wanted = _wanted(work)
    chunks = len(parts(starts, CHUNK))
    steps = chunks + 2  # plus a proof, plus reading the leaves
    work.tally = Tally(progress, len(wanted) * (steps + chunks))
    begin(work, wanted, starts)
    for index, corank in enumerate(wanted):
        work.tally.reach(index * steps)
        if not read_corank(work, corank, starts):
            wanted = wanted[: index + 1]
            break
    work.tally.reach(work.tally.total - len(wanted) * chunks)
    hold_out(work, [corank for corank in wanted if work.of(corank)], starts)
    work.tally.reach(work.tally.total)
