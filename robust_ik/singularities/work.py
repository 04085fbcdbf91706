"""The work on one corank: search, read, hold out. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.singularities.atlas import Settings
from robust_ik.singularities.confidence import Evidence, Status
from robust_ik.singularities.facts import RobotFacts
from robust_ik.singularities.finder import find_points
from robust_ik.singularities.leaves import Leaf
from robust_ik.singularities.points import Points
from robust_ik.singularities.survey import accounts, survey
from robust_ik.singularities.walking import Mask

PROBE = 500
"""Starts after which a corank that none led to counts as not there."""
HOLDOUTS = 2
"""A hold-out that met something new is used to extend the list, and another one made."""


@dataclass
class Work:
    """What a search has done so far; it survives an interruption."""

    facts: RobotFacts
    settings: Settings
    leaves: list[Leaf]
    evidence: dict[int, Evidence]

    def rng(self, corank: int, stage: int) -> np.random.Generator:
        """Of its own for every corank and stage, so that results do not depend on the order of the work."""
        return np.random.default_rng([self.settings.seed, corank, stage, self.settings.starts])

    def find(self, corank: int, starts: int, stage: int) -> Points:
        """Points from fresh starts."""
        return find_points(
            self.facts.chain, corank, starts, self.rng(corank, stage),
            method=self.settings.method, tolerance=self.settings.tolerance,
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
    added = Evidence(
        corank, Status.INTERRUPTED, sum(len(part) + part.failed for part in parts), len(values), int(exact.sum()),
        unexplained=int(np.sum(~found.explained)), rejected=found.rejected,
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
    """Fresh starts against the frozen list; what they meet that is not in it is read, and others are made."""
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
