"""The work on one corank: search, read, hold out. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from robust_ik.certificates import Proof
from robust_ik.certificates.certify import certify_plain
from robust_ik.checks import Array
from robust_ik.singularities.atlas import Settings, SingularityAtlas
from robust_ik.singularities.confidence import Evidence, Status
from robust_ik.singularities.facts import RobotFacts
from robust_ik.singularities.finder import find_points
from robust_ik.singularities.leaves import Leaf
from robust_ik.singularities.merging import joined
from robust_ik.singularities.points import Points
from robust_ik.singularities.proving import Proven
from robust_ik.singularities.survey import accounts, survey, uncovered
from robust_ik.singularities.walking import Mask

PROBE = 500
"""Starts after which a corank that none led to counts as not there."""
HOLDOUTS = 2
"""A hold-out that met something new is used to extend the list, and another one made."""


@dataclass
class Work:
    """What a search has done so far; it survives an interruption.

    Attributes:
        facts: What is searched.
        settings: How.
        leaves: What was found.
        evidence: What is known of each corank.
        proven: The proofs that were tried.
        unread: Points that the leaves found at first did not account for, (N, n) for each corank.
    """

    facts: RobotFacts
    settings: Settings
    leaves: list[Leaf] = field(default_factory=list)
    evidence: dict[int, Evidence] = field(default_factory=dict)
    proven: dict[int, Proven] = field(default_factory=dict)
    unread: dict[int, Array] = field(default_factory=dict)

    def rng(self, corank: int, stage: int) -> np.random.Generator:
        """Of its own for every corank and stage, so that results do not depend on the order of the work."""
        return np.random.default_rng([self.settings.seed, corank, stage, self.settings.starts])

    def find(self, corank: int, starts: int, stage: int) -> Points:
        """Points from fresh starts."""
        return find_points(
            self.facts.chain, corank, starts, self.rng(corank, stage),
            method=self.settings.method, tolerance=self.settings.tolerance, measured=False,
        )  # fmt: skip

    def of(self, corank: int) -> list[Leaf]:
        """Leaves of one corank."""
        return [leaf for leaf in self.leaves if leaf.corank == corank]

    def accounted(self, corank: int, points: Points) -> Mask:
        """Which points lie on a leaf; those of coranks that were not looked for count as such."""
        leaves = [leaf for leaf in self.leaves if leaf.corank >= corank]
        known = accounts(self.facts.chain, corank, leaves, points.values)
        return np.asarray(known | ((points.coranks > corank) & (self.settings.corank is not None)))


def read_corank(work: Work, corank: int, starts: int) -> bool:
    """Searches one corank and reads its leaves; whether there is one."""
    work.evidence[corank] = _add(work, corank, Evidence(corank, Status.INTERRUPTED, 0, 0, 0))
    parts = [work.find(corank, min(starts, PROBE), 1)]
    if len(parts[0]) == 0 and not work.of(corank):
        tried, floor = parts[0].failed + work.evidence[corank].starts, float(parts[0].floors.min(initial=1.0))
        none = Evidence(corank, Status.NONE_FOUND, tried, 0, 0, fresh=tried, floor=floor)
        work.evidence[corank] = none
        return False
    if starts > PROBE:
        parts.append(work.find(corank, starts - PROBE, 2))
    values = np.concatenate([part.values for part in parts])
    exact = np.concatenate([part.coranks for part in parts]) == corank
    found = survey(work.facts.chain, corank, values[exact], work.rng(corank, 3), known=work.of(corank))
    work.leaves = [leaf for leaf in work.leaves if leaf.corank != corank] + list(found.leaves)
    work.unread[corank] = values[exact][~found.explained]
    added = Evidence(
        corank, Status.INTERRUPTED, sum(len(part) + part.failed for part in parts), len(values), int(exact.sum()),
        rejected=found.rejected,
    )  # fmt: skip
    work.evidence[corank] = _add(work, corank, added)
    return True


def _add(work: Work, corank: int, new: Evidence) -> Evidence:
    """The counts of earlier searches and of this one."""
    old = work.evidence.get(corank)
    if old is None:
        return new
    return replace(
        new, starts=old.starts + new.starts, found=old.found + new.found, exact=old.exact + new.exact,
        rejected=old.rejected + new.rejected, floor=0.0,
    )  # fmt: skip


def hold_out(work: Work, corank: int, starts: int) -> None:
    """Fresh starts against the frozen list; what they meet that is not in it is read, and others are made.

    Few, and only to hold them against it, where there is an accepted proof.
    """
    if corank in work.proven and work.proven[corank].accepted:
        starts = min(starts, PROBE)
    for attempt in range(HOLDOUTS):
        points = work.find(corank, starts, 10 + attempt)
        new = ~work.accounted(corank, points)
        work.evidence[corank] = replace(
            work.evidence[corank], status=Status.ESTIMATE, fresh=len(points) + points.failed, unmatched=int(new.sum())
        )
        if not new.any() or attempt == HOLDOUTS - 1:
            return
        exact = points.values[new & (points.coranks == corank)]
        found = survey(work.facts.chain, corank, exact, work.rng(corank, 20 + attempt), known=work.of(corank))
        if len(found.leaves) == len(work.of(corank)):
            return
        work.leaves = [leaf for leaf in work.leaves if leaf.corank != corank] + list(found.leaves)


def prove(work: Work, corank: int) -> bool:
    """Tries a proof of the list of one corank, and reads what it has that the list lacks; whether there is any leaf.

    A proof that was made before is used again: it is about the arm, not about the list.
    """
    facts = work.facts
    if corank not in work.proven:
        proof = Proof(None, corank, reason=facts.inexact) if facts.exact is None else certify_plain(facts.exact, corank)
        work.proven[corank] = Proven.of(facts.chain, facts.exact, proof)
    proven = work.proven[corank]
    lacking = proven.unlisted(facts.chain, work.of(corank), only=True)
    if len(lacking):
        # A curve would account for these points too: it is put aside until they have been read.
        curves = [leaf for leaf in work.of(corank) if leaf.curve]
        others = [leaf for leaf in work.of(corank) if not leaf.curve]
        found = survey(facts.chain, corank, lacking, work.rng(corank, 30), known=others)
        work.leaves = [leaf for leaf in work.leaves if leaf.corank != corank] + uncovered(
            joined([*curves, *found.leaves])
        )
    return bool(work.of(corank))


def judged(work: Work) -> tuple[Evidence, ...]:
    """The evidence of every corank once lists and proofs are final and held against each other.

    What was certified without a proof at hand is not certified.
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


def work_of(atlas: SingularityAtlas) -> Work:
    """The work that an atlas is the result of, its proofs checked again."""
    facts = atlas.robot
    return Work(
        facts,
        atlas.settings,
        [leaf for stratum in atlas.strata for leaf in stratum.leaves],
        {each.corank: each for each in atlas.evidence},
        {proof.corank: Proven.of(facts.chain, facts.exact, proof) for proof in atlas.certificate or ()},
    )
