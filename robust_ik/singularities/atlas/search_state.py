"""What a search for an atlas has done so far, and who does its pieces. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field

import numpy as np

from robust_ik.checks import Array
from robust_ik.runtime.parallel import run_pieces
from robust_ik.runtime.progress import Told
from robust_ik.singularities.atlas.atlas_record import AtlasRecord, Settings
from robust_ik.singularities.atlas.evidence import Evidence
from robust_ik.singularities.atlas.proof_evidence import ProofOutcome
from robust_ik.singularities.atlas.search_pieces import Chunk, ProofOf, run
from robust_ik.singularities.conditions.arm_record import RobotFacts
from robust_ik.singularities.families.leaf import Leaf
from robust_ik.singularities.families.leaf_survey import accounts
from robust_ik.singularities.find.points_found import Points
from robust_ik.singularities.find.tangent_walk import Mask


@dataclass
class Tally:
    """How much of the work is done, for who wants to know.

    Attributes:
        told: Called with (steps done, steps in all).
        total: Steps in all: pieces, and one for the reading of every corank.
        done: Steps done.
    """

    told: Told | None = None
    total: int = 1
    done: int = 0

    def reach(self, done: int) -> None:
        """So much is done, or more already; what is done beyond what was foreseen does not count."""
        self.done = min(max(done, self.done), self.total)
        if self.told is not None:
            self.told(self.done, self.total)


@dataclass
class SearchState:
    """What a search has done so far; it survives an interruption.

    Attributes:
        facts: What is searched.
        settings: How.
        leaves: What was found.
        evidence: What is known of each corank.
        proven: The proofs that were tried.
        unread: Points that the leaves found at first did not account for, (N, n) for each corank.
        executor: Who does its pieces; None for this process.
        tally: How much is done.
        ahead: What came of pieces that were done before they were asked for.
    """

    facts: RobotFacts
    settings: Settings
    leaves: list[Leaf] = field(default_factory=list)
    evidence: dict[int, Evidence] = field(default_factory=dict)
    proven: dict[int, ProofOutcome] = field(default_factory=dict)
    unread: dict[int, Array] = field(default_factory=dict)
    executor: Executor | None = None
    tally: Tally = field(default_factory=Tally)
    ahead: dict[Chunk | ProofOf, Points | ProofOutcome] = field(default_factory=dict)

    def seed(self, corank: int, stage: int) -> tuple[int, ...]:
        """Of its own for every corank and stage, so that results do not depend on the order of the work."""
        return self.settings.seed, corank, stage, self.settings.starts

    def rng(self, corank: int, stage: int) -> np.random.Generator:
        """Random numbers of that seed."""
        return np.random.default_rng(self.seed(corank, stage))

    def search(self, corank: int, starts: int, stage: int) -> list[Chunk]:
        """Fresh starts, in pieces."""
        seed, settings = self.seed(corank, stage), self.settings
        return Chunk(self.facts.chain, corank, starts, seed, settings.method, settings.tolerance).split()

    def proof(self, corank: int) -> list[ProofOf]:
        """The proof of one corank, in pieces: none where none is wanted, or one was tried."""
        if not self.settings.certified or corank in self.proven:
            return []
        return [ProofOf(self.facts.chain, self.facts.exact, self.facts.inexact, corank)]

    def run_ahead(self, pieces: Sequence[Chunk | ProofOf]) -> None:
        """Has pieces done that may be asked for, all at once; some may turn out not to be needed."""
        self.ahead.update(zip(pieces, self._results(pieces)))

    def run(self, pieces: Sequence[Chunk | ProofOf]) -> tuple[list[Points], list[ProofOutcome]]:
        """What comes of pieces, in their order."""
        self.run_ahead([piece for piece in pieces if piece not in self.ahead])
        found = [self.ahead.pop(piece) for piece in pieces]
        points = [each for each in found if isinstance(each, Points)]
        return points, [each for each in found if isinstance(each, ProofOutcome)]

    def _results(self, pieces: Sequence[Chunk | ProofOf]) -> list[Points | ProofOutcome]:
        before = self.tally.done
        return run_pieces(run, pieces, self.executor, lambda done, _: self.tally.reach(before + done))

    def of(self, corank: int) -> list[Leaf]:
        """Leaves of one corank."""
        return [leaf for leaf in self.leaves if leaf.corank == corank]

    def accounted(self, corank: int, points: Points) -> Mask:
        """Which points lie on a leaf; those of coranks that were not looked for count as such."""
        leaves = [leaf for leaf in self.leaves if leaf.corank >= corank]
        known = accounts(self.facts.chain, corank, leaves, points.values)
        return np.asarray(known | ((points.coranks > corank) & (self.settings.corank is not None)))


def work_of(atlas: AtlasRecord) -> SearchState:
    """The work that an atlas is the result of, its proofs checked again."""
    facts = atlas.robot
    return SearchState(
        facts,
        atlas.settings,
        [leaf for stratum in atlas.strata for leaf in stratum.leaves],
        {each.corank: each for each in atlas.evidence},
        {proof.corank: ProofOutcome.of(facts.chain, facts.exact, proof) for proof in atlas.certificate or ()},
    )
