"""The search for one corank: its pieces, the leaves read from them, the proof, and the hold-out. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.singularities.atlas.evidence import Completeness, Evidence
from robust_ik.singularities.atlas.floating_base import never_singular
from robust_ik.singularities.atlas.search_pieces import CHUNK, Chunk, ProofOf
from robust_ik.singularities.atlas.search_state import SearchState
from robust_ik.singularities.families.leaf import Leaf
from robust_ik.singularities.families.leaf_merging import joined
from robust_ik.singularities.families.leaf_survey import accounts, survey, uncovered
from robust_ik.singularities.find.points_found import Points

PROBE = CHUNK
"""Starts after which a corank that none of them reached counts as not existing."""
HOLDOUTS = 2
"""Most hold-outs: if one meets something new, the list is extended and another one is made."""


@dataclass(frozen=True)
class CorankSearch:
    """The search for one corank.

    Attributes:
        state: What the search for the atlas has found; it is changed.
        corank: The corank that is looked for.
    """

    state: SearchState
    corank: int

    def pieces(self, starts: int) -> list[Chunk | ProofOf]:
        """The pieces that the search begins with: a proof, if one is to be tried, and the first starts."""
        return [*self._proof(), *self._chunks(min(starts, PROBE), 1)]

    def read(self, starts: int) -> bool:
        """Runs the pieces, reads leaves from their points and from the proof, and returns whether there is any.

        A proof that was made before is used again: it is about the arm, not about the list.
        """
        state, corank = self.state, self.corank
        self._add(Evidence(corank, Completeness.INTERRUPTED, 0, 0, 0))
        parts, tried = state.run(self.pieces(starts))
        state.proven.update({each.proof.corank: each for each in tried})
        found = self._read_points(starts, parts)
        return self._read_proof() or found if state.settings.certified else found

    def fresh(self, starts: int, attempt: int = 0) -> list[Chunk]:
        """Fresh starts for a hold-out; few, if there is an accepted proof."""
        proven = self.state.proven.get(self.corank)
        return self._chunks(min(starts, PROBE) if proven is not None and proven.accepted else starts, 10 + attempt)

    def hold_out(self, starts: int, points: list[Points]) -> None:
        """Holds fresh points against the frozen list, reads those that are not in it, and makes another hold-out."""
        for attempt in range(HOLDOUTS):
            if attempt > 0:
                points, _ = self.state.run(self.fresh(starts, attempt))
            if not self._extended(Points.joined(points), attempt):
                break

    def judged(self, *, only: bool) -> Evidence:
        """The evidence once the lists and the proof are final and held against each other.

        What was certified without a proof at hand is not certified.

        Args:
            only: Whether no other corank was looked for.
        """
        state, corank, evidence = self.state, self.corank, self.state.evidence[self.corank]
        if corank in state.unread:
            unexplained = int(np.sum(~accounts(state.facts.chain, corank, self.leaves, state.unread[corank])))
            evidence = replace(evidence, unexplained=unexplained)
        proven = state.proven.get(corank)
        if proven is None:
            return replace(evidence, status=evidence.estimated, cases=0, leaves=0)
        listed = [leaf for leaf in state.leaves if leaf.corank >= corank]
        unlisted = len(proven.unlisted(state.facts.chain, listed, only=only))
        return proven.judged(evidence, unlisted, proven.strays(state.facts.chain, listed))

    @property
    def leaves(self) -> list[Leaf]:
        """The leaves of this corank that were found so far."""
        return self.state.of(self.corank)

    def _chunks(self, starts: int, stage: int) -> list[Chunk]:
        """Random starts, in pieces."""
        seed, settings = self.state.seed(self.corank, stage), self.state.settings
        return Chunk(self.state.facts.chain, self.corank, starts, seed, settings.method, settings.tolerance).split()

    def _proof(self) -> list[ProofOf]:
        """The proof, as a piece: none if none is wanted, or one was tried."""
        facts = self.state.facts
        if not self.state.settings.certified or self.corank in self.state.proven:
            return []
        return [ProofOf(facts.chain, facts.exact, facts.inexact, self.corank)]

    def _survey(self, points: Array, stage: int, known: list[Leaf]) -> list[Leaf]:
        """Leaves of points, those that are known among them."""
        found = survey(self.state.facts.chain, self.corank, points, self.state.rng(self.corank, stage), known=known)
        return list(found.leaves)

    def _keep(self, leaves: list[Leaf]) -> None:
        """Puts leaves in the place of those of this corank."""
        self.state.leaves = [leaf for leaf in self.state.leaves if leaf.corank != self.corank] + leaves

    def _add(self, new: Evidence) -> None:
        """Adds the counts of this search to those of earlier ones."""
        old = self.state.evidence.get(self.corank)
        self.state.evidence[self.corank] = new if old is None else replace(
            new, starts=old.starts + new.starts, found=old.found + new.found, exact=old.exact + new.exact,
            rejected=old.rejected + new.rejected, floor=0.0,
        )  # fmt: skip

    def _read_points(self, starts: int, parts: list[Points]) -> bool:
        """Reads leaves from the points of the first starts and of the others; returns whether there is one."""
        state, corank = self.state, self.corank
        if sum(len(part) for part in parts) == 0 and not self.leaves:
            floor = min(float(part.floors.min(initial=1.0)) for part in parts)
            tried = sum(part.failed for part in parts) + state.evidence[corank].starts
            state.evidence[corank] = Evidence(corank, Completeness.NONE_FOUND, tried, 0, 0, fresh=tried, floor=floor)
            return False
        if starts > PROBE:
            parts = [*parts, *state.run(self._chunks(starts - PROBE, 2))[0]]
        values = np.concatenate([part.values for part in parts])
        exact = np.concatenate([part.coranks for part in parts]) == corank
        found = survey(state.facts.chain, corank, values[exact], state.rng(corank, 3), known=self.leaves)
        self._keep(list(found.leaves))
        state.unread[corank] = values[exact][~found.explained]
        tried = sum(len(part) + part.failed for part in parts)
        counts = (tried, len(values), int(exact.sum()))
        self._add(Evidence(corank, Completeness.INTERRUPTED, *counts, rejected=found.rejected))
        return True

    def _read_proof(self) -> bool:
        """Reads what the proof has and the list lacks; returns whether there is any leaf."""
        lacking = self.state.proven[self.corank].unlisted(self.state.facts.chain, self.leaves, only=True)
        if len(lacking):
            # A curve would account for these points too: it is put aside until they have been read.
            curves = [leaf for leaf in self.leaves if leaf.curve]
            others = [leaf for leaf in self.leaves if not leaf.curve]
            self._keep(uncovered(joined([*curves, *self._survey(lacking, 30, others)])))
        return bool(self.leaves)

    def _extended(self, points: Points, attempt: int) -> bool:
        """Holds points against the list; returns whether it grew and another hold-out is to be made."""
        state, corank = self.state, self.corank
        new = ~state.accounted(corank, points)
        state.evidence[corank] = replace(
            state.evidence[corank],
            status=Completeness.ESTIMATE,
            fresh=len(points) + points.failed,
            unmatched=int(new.sum()),
        )
        if not new.any() or attempt == HOLDOUTS - 1:
            return False
        exact = points.values[new & (points.coranks == corank)]
        found = self._survey(exact, 20 + attempt, self.leaves)
        if len(found) == len(self.leaves):
            return False
        self._keep(found)
        return True


def judged(state: SearchState) -> tuple[Evidence, ...]:
    """The evidence of every corank that was looked for, once lists and proofs are final; see `CorankSearch.judged`."""
    only = state.settings.corank is not None
    if never := never_singular(state.facts, state.settings.corank):
        return never
    return tuple(CorankSearch(state, corank).judged(only=only) for corank in sorted(state.evidence))
