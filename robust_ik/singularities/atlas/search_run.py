"""Runs one search from its first start to its rows; a continued search runs the same code."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from robust_ik.certificates import Certificate
from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError
from robust_ik.runtime.parallel import chunk_sizes
from robust_ik.runtime.progress import ProgressCallback
from robust_ik.singularities.atlas.atlas_record import AtlasRecord
from robust_ik.singularities.atlas.corank_search import CorankSearch, judged
from robust_ik.singularities.atlas.evidence import Completeness, Evidence
from robust_ik.singularities.atlas.floating_base import never_singular
from robust_ik.singularities.atlas.search_pieces import CHUNK
from robust_ik.singularities.atlas.search_state import SearchState, Tally, state_of
from robust_ik.singularities.families.near_rows import is_listed
from robust_ik.singularities.families.stratum import Stratum
from robust_ik.singularities.families.stratum_rows import in_metres, make_rows

NEAR = 250
"""Starts for each corank of an arm without small tilts and offsets. Chosen: half of a chunk, which takes a second."""


@checked
def extend(
    atlas: AtlasRecord, starts: int, executor: Executor | None = None, progress: ProgressCallback | None = None
) -> AtlasRecord:
    """An atlas after further starts for each corank; see `SingularityAtlas.extended`."""
    if isinstance(starts, bool) or not isinstance(starts, (int, np.integer)) or starts < 1:
        raise InputError(f"starts must be a whole number of at least 1, got {starts!r}")
    state = state_of(atlas)
    state.settings = replace(atlas.settings, starts=atlas.settings.starts + int(starts))
    state.executor = executor
    found = searched(state, int(starts), progress)
    return replace(found, nearly=atlas.nearly) if found.interrupted and not found.nearly else found


def searched(state: SearchState, starts: int, progress: ProgressCallback | None) -> AtlasRecord:
    """The record after these starts for each corank, or after Ctrl-C."""
    facts, interrupted = state.facts.measured_in(1 / state.facts.units), False
    if never := never_singular(facts, state.settings.corank):
        Tally(progress).reach(1)
        return AtlasRecord(facts, (), never, state.settings)
    try:
        _search(state, starts, progress)
    except KeyboardInterrupt:
        interrupted = True
        _mark_what_is_left(state)
    strata: list[Stratum] = []
    try:
        for made in make_rows(state.facts, state.leaves, state.rng(0, 9)):
            strata += made
        evidence = judged(state)
    except KeyboardInterrupt:
        interrupted, evidence = True, _unjudged(state)
    nearly: tuple[Stratum, ...] = ()
    try:
        nearly = () if interrupted else _nearly(state, strata)
    except KeyboardInterrupt:
        interrupted = True
    proofs = tuple(state.proven[k].proof for k in sorted(state.proven))
    certificate = Certificate(proofs) if proofs else None
    listed = tuple(in_metres(state.facts, row) for row in strata)
    return AtlasRecord(facts, listed, evidence, state.settings, interrupted, certificate, nearly)


def _nearly(state: SearchState, strata: Sequence[Stratum]) -> tuple[Stratum, ...]:
    """The rows of the arm without its small tilts and offsets that are no rows of the arm.

    Nothing is claimed of their completeness: there is no hold-out and no proof.
    """
    facts = state.facts.nearly
    if facts is None:
        return ()
    near = SearchState(facts, replace(state.settings, starts=NEAR, certified=False), executor=state.executor)
    for corank in _wanted(near):
        if not CorankSearch(near, corank).read(NEAR):
            break
    rows = [row for made in make_rows(facts, near.leaves, near.rng(0, 9)) for row in made]
    return tuple(in_metres(facts, row) for row in rows if not is_listed(state.facts.chain, strata, row))


def _wanted(state: SearchState) -> list[int]:
    """The coranks to look for; the search stops at the first one that does not exist."""
    return [state.settings.corank] if state.settings.corank else list(range(1, state.facts.chain.full_rank + 1))


def _search(state: SearchState, starts: int, progress: ProgressCallback | None) -> None:
    """Runs the search step by step: each corank is searched, proved if possible and read; then all have a hold-out."""
    searches = [CorankSearch(state, corank) for corank in _wanted(state)]
    chunks = len(chunk_sizes(starts, CHUNK))
    steps = chunks + 2  # plus a proof, plus reading the leaves
    state.tally = Tally(progress, len(searches) * (steps + chunks))
    if state.executor is not None:  # pieces for coranks that do not exist only cost time of workers that would be idle
        state.run_ahead([piece for each in searches for piece in each.pieces(starts)])
    for index, each in enumerate(searches):
        state.tally.reach(index * steps)
        if not each.read(starts):
            searches = searches[: index + 1]
            break
    state.tally.reach(state.tally.total - len(searches) * chunks)
    none = Completeness.NONE_FOUND
    _hold_out([each for each in searches if state.evidence[each.corank].status is not none], state, starts)
    state.tally.reach(state.tally.total)


def _hold_out(searches: list[CorankSearch], state: SearchState, starts: int) -> None:
    """Fresh starts against the frozen lists of all coranks, which are searched at once."""
    points, _ = state.run([chunk for each in searches for chunk in each.fresh(starts)])
    for each in searches:
        each.hold_out(starts, [part for part in points if part.corank == each.corank])


def _mark_what_is_left(state: SearchState) -> None:
    """Marks the coranks that an interrupted search did not come to."""
    if not any(each.status is Completeness.NONE_FOUND for each in state.evidence.values()):
        for corank in _wanted(state):
            state.evidence.setdefault(corank, Evidence(corank, Completeness.INTERRUPTED, 0, 0, 0))


def _unjudged(state: SearchState) -> tuple[Evidence, ...]:
    """The evidence of lists that are not whole, so that nothing can be held against them."""
    evidence = [each for _, each in sorted(state.evidence.items())]
    return tuple(replace(each, status=Completeness.INTERRUPTED, fresh=0, unmatched=0, proof="") for each in evidence)
