"""State of an atlas search: what it has found, its progress, and the executor that runs its pieces. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from itertools import chain

import numpy as np

from robust_ik.checks import Array
from robust_ik.runtime.parallel import run_pieces
from robust_ik.runtime.progress import ProgressCallback
from robust_ik.singularities.atlas.atlas_record import AtlasRecord, Settings
from robust_ik.singularities.atlas.evidence import Evidence
from robust_ik.singularities.atlas.proof_evidence import ProofOutcome
from robust_ik.singularities.atlas.search_pieces import Chunk, ProofOf, run, run_together, together
from robust_ik.singularities.conditions.robot_facts import RobotFacts
from robust_ik.singularities.families.leaf import Leaf
from robust_ik.singularities.families.leaf_survey import accounts
from robust_ik.singularities.find.points_found import Points
from robust_ik.singularities.find.tangent_walk import Mask


@dataclass
class Tally:
    """Progress of a search, reported to a callback.

    Attributes:
        told: Called with (steps done, steps in all).
        total: Steps in all: pieces, and one for the reading of every corank.
        done: Steps done.
    """

    told: ProgressCallback | None = None
    total: int = 1
    done: int = 0

    def reach(self, done: int) -> None:
        """Reports that `done` steps are done; the count never falls and never exceeds the total."""
        self.done = min(max(done, self.done), self.total)
        if self.told is not None:
            self.told(self.done, self.total)


@dataclass
class SearchState:
    """The state of a search, which survives an interruption.

    Attributes:
        facts: Facts of the robot, with joint values in the units of `RobotFacts.units`.
        settings: Settings of the search.
        leaves: Leaves found so far.
        evidence: Evidence for each corank.
        proven: Outcomes of the proofs that were tried, by corank.
        unread: Points that lay on no leaf when they were read first, (N, n) for each corank.
        executor: The executor that runs the pieces; None for this process.
        tally: Progress of the search.
        ahead: Results of pieces that were run before they were needed.
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
        """A seed for each corank and stage, so that results do not depend on the order of the work."""
        return self.settings.seed, corank, stage, self.settings.starts

    def rng(self, corank: int, stage: int) -> np.random.Generator:
        """A generator with that seed."""
        return np.random.default_rng(self.seed(corank, stage))

    def run_ahead(self, pieces: Sequence[Chunk | ProofOf]) -> None:
        """Runs pieces that may be needed later, all at once."""
        self.ahead.update(zip(pieces, self._results(pieces)))

    def run(self, pieces: Sequence[Chunk | ProofOf]) -> tuple[list[Points], list[ProofOutcome]]:
        """The results of pieces, in order: points of chunks, and outcomes of proofs."""
        self.run_ahead([piece for piece in pieces if piece not in self.ahead])
        found = [self.ahead.pop(piece) for piece in pieces]
        points = [each for each in found if isinstance(each, Points)]
        return points, [each for each in found if isinstance(each, ProofOutcome)]

    def _results(self, pieces: Sequence[Chunk | ProofOf]) -> list[Points | ProofOutcome]:
        before = self.tally.done
        if self.executor is not None:
            return run_pieces(run, pieces, self.executor, lambda done, _: self.tally.reach(before + done))
        groups = together(pieces)
        ends = np.cumsum([len(group) for group in groups])
        found = run_pieces(run_together, groups, None, lambda done, _: self.tally.reach(before + int(ends[done - 1])))
        return list(chain.from_iterable(found))

    def of(self, corank: int) -> list[Leaf]:
        """The leaves of one corank."""
        return [leaf for leaf in self.leaves if leaf.corank == corank]

    def accounted(self, corank: int, points: Points) -> Mask:
        """Which points lie on a leaf; points of coranks that were not looked for count too."""
        leaves = [leaf for leaf in self.leaves if leaf.corank >= corank]
        known = accounts(self.facts.chain, corank, leaves, points.values)
        return np.asarray(known | ((points.coranks > corank) & (self.settings.corank is not None)))


def state_of(atlas: AtlasRecord) -> SearchState:
    """The state from which an atlas can be continued; its proofs are checked again."""
    units = atlas.robot.units
    facts = atlas.robot.measured_in(units)
    return SearchState(
        facts,
        atlas.settings,
        [leaf for stratum in atlas.strata for leaf in stratum.measured_in(units, facts.symbols).leaves],
        {each.corank: each for each in atlas.evidence},
        {proof.corank: ProofOutcome.of(facts.chain, facts.exact, proof) for proof in atlas.certificate or ()},
    )
