"""The search for one corank: random starts, leaves, a proof, a hold-out. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robust_ik.singularities.atlas.evidence import Completeness, Evidence
from robust_ik.singularities.atlas.search_pieces import CHUNK, Chunk, ProofOf
from robust_ik.singularities.atlas.search_state import SearchState
from robust_ik.singularities.families.leaf_merging import joined
from robust_ik.singularities.families.leaf_survey import accounts, survey, uncovered
from robust_ik.singularities.find.points_found import Points

PROBE = CHUNK
"""Starts after which a corank that none of them reached counts as not existing."""
HOLDOUTS = 2
"""Most hold-outs: if one meets something new, the list is extended and another one is made."""


def begin(work: SearchState, coranks: Sequence[int], starts: int) -> None:
    """Starts the first pieces of all coranks at once, if there is an executor.

    Pieces for coranks that do not exist are wasted, but only cost time of workers that would be idle.
    """
    if work.executor is not None:
        work.run_ahead([piece for corank in coranks for piece in _beginning(work, corank, starts)])


def _beginning(work: SearchState, corank: int, starts: int) -> list[Chunk | ProofOf]:
    return [*work.proof(corank), *work.search(corank, min(starts, PROBE), 1)]


def read_corank(work: SearchState, corank: int, starts: int) -> bool:
    """Searches one corank, tries a proof and reads the leaves; False if there are none.

    A proof that was made before is reused: it is about the arm, not about the list.
    """
    work.evidence[corank] = _add(work, corank, Evidence(corank, Completeness.INTERRUPTED, 0, 0, 0))
    parts, tried = work.run(_beginning(work, corank, starts))
    work.proven.update({each.proof.corank: each for each in tried})
    found = _read_points(work, corank, starts, parts)
    if work.settings.certified:
        found |= _read_proof(work, corank)
    return found


def _read_points(work: SearchState, corank: int, starts: int, parts: list[Points]) -> bool:
    """Reads leaves from the points of the first starts and then of the others; False if there are none."""
    if sum(len(part) for part in parts) == 0 and not work.of(corank):
        floor = min(float(part.floors.min(initial=1.0)) for part in parts)
        tried = sum(part.failed for part in parts) + work.evidence[corank].starts
        work.evidence[corank] = Evidence(corank, Completeness.NONE_FOUND, tried, 0, 0, fresh=tried, floor=floor)
        return False
    if starts > PROBE:
        parts = [*parts, *work.run(work.search(corank, starts - PROBE, 2))[0]]
    values = np.concatenate([part.values for part in parts])
    exact = np.concatenate([part.coranks for part in parts]) == corank
    found = survey(work.facts.chain, corank, values[exact], work.rng(corank, 3), known=work.of(corank))
    work.leaves = [leaf for leaf in work.leaves if leaf.corank != corank] + list(found.leaves)
    work.unread[corank] = values[exact][~found.explained]
    added = Evidence(
        corank, Completeness.INTERRUPTED, sum(len(part) + part.failed for part in parts), len(values), int(exact.sum()),
        rejected=found.rejected,
    )  # fmt: skip
    work.evidence[corank] = _add(work, corank, added)
    return True


def _add(work: SearchState, corank: int, new: Evidence) -> Evidence:
    """The sum of the counts of earlier searches and of this one."""
    old = work.evidence.get(corank)
    if old is None:
        return new
    return replace(
        new, starts=old.starts + new.starts, found=old.found + new.found, exact=old.exact + new.exact,
        rejected=old.rejected + new.rejected, floor=0.0,
    )  # fmt: skip


def hold_out(work: SearchState, coranks: Sequence[int], starts: int) -> None:
    """Tests the frozen lists with fresh starts; points that are not listed are read, and another hold-out is made.

    If there is an accepted proof, a few starts are enough, which only test the list.
    """
    fresh = {corank: _fresh(work, corank, starts) for corank in coranks}
    first, _ = work.run([chunk for corank in coranks for chunk in work.search(corank, fresh[corank], 10)])
    for corank in coranks:
        points = [part for part in first if part.corank == corank]
        for attempt in range(HOLDOUTS):
            if attempt > 0:
                points, _ = work.run(work.search(corank, fresh[corank], 10 + attempt))
            if not _extended(work, corank, Points.joined(points), attempt):
                break


def _extended(work: SearchState, corank: int, points: Points, attempt: int) -> bool:
    """Tests the list with points; True if it was extended, so that another hold-out is needed."""
    new = ~work.accounted(corank, points)
    work.evidence[corank] = replace(
        work.evidence[corank], status=Completeness.ESTIMATE, fresh=len(points) + points.failed, unmatched=int(new.sum())
    )
    if not new.any() or attempt == HOLDOUTS - 1:
        return False
    exact = points.values[new & (points.coranks == corank)]
    found = survey(work.facts.chain, corank, exact, work.rng(corank, 20 + attempt), known=work.of(corank))
    if len(found.leaves) == len(work.of(corank)):
        return False
    work.leaves = [leaf for leaf in work.leaves if leaf.corank != corank] + list(found.leaves)
    return True


def _fresh(work: SearchState, corank: int, starts: int) -> int:
    return min(starts, PROBE) if corank in work.proven and work.proven[corank].accepted else starts


def _read_proof(work: SearchState, corank: int) -> bool:
    """Reads the points of a proof that the list lacks; False if the corank has no leaves at all."""
    proven = work.proven[corank]
    lacking = proven.unlisted(work.facts.chain, work.of(corank), only=True)
    if len(lacking):
        # A curve would account for these points too, so curves are put aside until the points are read.
        curves = [leaf for leaf in work.of(corank) if leaf.curve]
        others = [leaf for leaf in work.of(corank) if not leaf.curve]
        found = survey(work.facts.chain, corank, lacking, work.rng(corank, 30), known=others)
        work.leaves = [leaf for leaf in work.leaves if leaf.corank != corank] + uncovered(
            joined([*curves, *found.leaves])
        )
    return bool(work.of(corank))


def say_what_is_left(work: SearchState, coranks: Sequence[int]) -> None:
    """Marks the coranks that an interrupted search did not reach."""
    if not any(each.status is Completeness.NONE_FOUND for each in work.evidence.values()):
        for corank in coranks:
            work.evidence.setdefault(corank, Evidence(corank, Completeness.INTERRUPTED, 0, 0, 0))


def unjudged(work: SearchState) -> tuple[Evidence, ...]:
    """The evidence of incomplete lists, without comparison with hold-outs or proofs."""
    evidence = [each for _, each in sorted(work.evidence.items())]
    return tuple(replace(each, status=Completeness.INTERRUPTED, fresh=0, unmatched=0, proof="") for each in evidence)


def judged(work: SearchState) -> tuple[Evidence, ...]:
    """The evidence of every corank, from comparing the final lists and proofs.

    A corank that was certified before, but has no proof now, is no longer certified.
    """
    found, only = [], work.settings.corank is not None
    for corank, evidence in sorted(work.evidence.items()):
        proven = work.proven.get(corank)
        if corank in work.unread:
            unexplained = int(np.sum(~accounts(work.facts.chain, corank, work.of(corank), work.unread[corank])))
            evidence = replace(evidence, unexplained=unexplained)
        if proven is None:
            found.append(replace(evidence, status=evidence.estimated, cases=0, leaves=0))
            continue
        listed = [leaf for leaf in work.leaves if leaf.corank >= corank]
        unlisted = len(proven.unlisted(work.facts.chain, listed, only=only))
        found.append(proven.judged(evidence, unlisted, proven.strays(work.facts.chain, listed)))
    return tuple(found)
