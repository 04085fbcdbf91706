"""Compares the list of one corank with an exact proof: whether it is complete, and what it lacks. Arrays and proofs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import compress

import numpy as np

from robust_ik.certificates import LeafPlace, Proof, Verdict, check, leaves
from robust_ik.certificates.proof import Arm, members
from robust_ik.checks import Array
from robust_ik.singularities.atlas.evidence import Completeness, Evidence
from robust_ik.singularities.families.leaf import Leaf, solved
from robust_ik.singularities.families.leaf_survey import accounts
from robust_ik.singularities.find.rank_residual import Indices, coranks
from robust_ik.singularities.find.tangent_walk import polished, relative_sigmas
from robust_ik.singularities.geometry.screw_chain import ScrewChain

POINTS = 24
"""Points on each leaf of a proof that the list must account for."""
STRAY = 1e-5
"""Largest distance of a configuration from the leaves of a complete proof."""


@dataclass(frozen=True, eq=False)
class ProofOutcome:
    """A proof of one corank, checked, and points on its leaves.

    Attributes:
        proof: The case split.
        verdict: The checker's verdict; None if there is nothing to check.
        places: Its leaves, at the real places of their fields.
        points: Joint values on all of them, (N, n).
        coranks: Corank of the arm at the points, (N,).
        owners: Index of the place of each point, (N,).
    """

    proof: Proof
    verdict: Verdict | None
    places: tuple[LeafPlace, ...]
    points: Array
    coranks: Indices
    owners: Indices

    @classmethod
    def of(cls, chain: ScrewChain, arm: Arm | None, proof: Proof) -> ProofOutcome:
        """Checks a proof and finds points on its leaves.

        Args:
            chain: The geometry of the atlas.
            arm: The same in rational numbers, which the proof must be about.
            proof: The proof.
        """
        closed = arm is not None and proof.status in ("proved", "implicit")
        verdict = check(proof, arm=arm, rounds=1) if closed else None
        by_leaf = [leaf.places for leaf in leaves(proof)] if verdict is not None and verdict.accepted else []
        if verdict is not None and verdict.accepted and verdict.places != tuple(map(len, by_leaf)):
            shown = sum(map(len, by_leaf))
            why = f"refused: its leaves are at {sum(verdict.places)} real places, and {shown} would be listed"
            verdict = replace(verdict, accepted=False, reason=why)
        if verdict is None or not verdict.accepted:
            return cls(proof, verdict, (), np.empty((0, chain.n)), *np.empty((2, 0), dtype=int))
        rng = np.random.default_rng(proof.corank)
        places = tuple(place for each in by_leaf for place in each)
        found = [members(place, rng, POINTS) for place in places]
        points = np.concatenate([np.empty((0, chain.n)), *found])
        points = polished(chain, points, proof.corank)
        owners = np.repeat(np.arange(len(places)), [len(each) for each in found])
        sigmas = relative_sigmas(chain, points)
        return cls(proof, verdict, places, points, coranks(sigmas[:, : chain.full_rank], 1.0), owners)

    @property
    def accepted(self) -> bool:
        """Whether the checker accepted the proof."""
        return self.verdict is not None and self.verdict.accepted

    def unlisted(self, chain: ScrewChain, listed: Sequence[Leaf], *, only: bool) -> Array:
        """Points on the proof's leaves that lie on no leaf of a list, (N, n).

        A curve has no equation: it accounts only for places on which samples of it lie, not for all of its dimension.

        Args:
            chain: The geometry.
            listed: Leaves of this corank and of higher ones.
            only: Whether points of higher coranks are left out, because the list has none of them.
        """
        wanted = (self.coranks == self.proof.corank) | (not only)
        curves, plain = [leaf for leaf in listed if leaf.curve], [leaf for leaf in listed if not leaf.curve]
        met = [tuple(bool(each.holds(leaf.samples, STRAY).any()) for leaf in curves) for each in self.places]
        lacking = np.array(wanted)
        for alike in dict.fromkeys(met):
            points = np.flatnonzero(wanted & np.array([each == alike for each in met])[self.owners])
            near = [*plain, *compress(curves, alike)]
            lacking[points] = ~accounts(chain, self.proof.corank, near, self.points[points])
        return np.asarray(self.points[lacking])

    def strays(self, chain: ScrewChain, listed: Sequence[Leaf]) -> int:
        """How many members of the list lie on no leaf of the proof; 0 if both are right.

        Members are samples, samples with their free joints anywhere, and other solutions of the conditions.
        """
        rng = np.random.default_rng(self.proof.corank)
        values = np.concatenate(
            [np.empty((0, chain.n))]
            + [
                each
                for leaf in listed
                if leaf.corank == self.proof.corank
                for each in (leaf.samples, leaf.filled(chain, rng), solved(chain, leaf, rng, POINTS))
            ]
        )
        for each in self.places:
            values = values[~each.holds(values, STRAY)]
        return len(values)

    def judged(self, evidence: Evidence, unlisted: int, strays: int) -> Evidence:
        """The evidence with the proof added: certified only if the checker accepted and the list agrees.

        Args:
            evidence: The evidence from random starts.
            unlisted: Points of the proof that the list lacks.
            strays: Samples of the list that the proof lacks.
        """
        verdict = self.verdict
        plain = replace(evidence, status=evidence.estimated, cases=0, leaves=0)
        if verdict is None:
            return replace(plain, proof=UNPROVED[self.proof.status].format(reason=self.proof.reason))
        if verdict.implicit:
            return replace(plain, status=Completeness.IMPLICIT, cases=verdict.cases, proof="")
        if not verdict.accepted:
            return replace(plain, proof=f"a proof was not accepted: {verdict.reason}")
        if unlisted or strays:
            lacks = ["a proof has configurations that the list lacks"] if unlisted else []
            lacks += ["the list has members that a proof lacks"] if strays else []
            return replace(plain, proof=", ".join(lacks))
        return replace(
            plain, status=Completeness.CERTIFIED, cases=verdict.cases, leaves=len(self.proof.leaves), proof=""
        )


UNPROVED = {
    "unsupported": "no proof was tried: {reason}",
    "open": "an exact case split was tried and did not close",
    "proved": "a proof was not checked",
    "implicit": "a proof was not checked",
}
