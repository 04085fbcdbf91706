"""Independent pieces of an atlas search, for workers: chunks of random starts, and proofs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robust_ik.certificates import Proof
from robust_ik.certificates.certify import certify_plain
from robust_ik.certificates.proof import Arm
from robust_ik.runtime.parallel import chunk_sizes
from robust_ik.singularities.atlas.proof_evidence import ProofOutcome
from robust_ik.singularities.find.find_points import Method, find_points, find_together
from robust_ik.singularities.find.points_found import Points
from robust_ik.singularities.geometry.screw_chain import ScrewChain

TOGETHER = 3
"""Most chunks that one process searches at once: all 1500 starts of a hold-out. More: Ctrl-C loses more."""
CHUNK = 500
"""Starts in a chunk; with more, products of their matrices would be split among threads."""


@dataclass(frozen=True)
class Chunk:
    """Random starts for one corank.

    Attributes:
        chain: What moves the tip.
        corank: The corank to look for.
        starts: Number of starts.
        seed: Seed of this chunk alone.
        method: "projection" or "gradient".
        tolerance: ‖r‖/σ₁ that counts as zero.
    """

    chain: ScrewChain
    corank: int
    starts: int
    seed: tuple[int, ...]
    method: Method
    tolerance: float

    def run(self) -> Points:
        """The points that the starts reach."""
        return find_points(
            self.chain, self.corank, self.starts, np.random.default_rng(self.seed),
            method=self.method, tolerance=self.tolerance, measured=False,
        )  # fmt: skip

    def split(self) -> list[Chunk]:
        """The same starts in chunks of at most CHUNK, each with a seed of its own, the first with this seed."""
        return [
            replace(self, starts=size, seed=(*self.seed, index) if index else self.seed)
            for index, size in enumerate(chunk_sizes(self.starts, CHUNK))
        ]


@dataclass(frozen=True)
class ProofOf:
    """A proof for one corank, to be tried and checked.

    Attributes:
        chain: The geometry of the atlas.
        arm: The same in rational numbers; None if that is not possible.
        inexact: Why it is not.
        corank: The corank.
    """

    chain: ScrewChain
    arm: Arm | None
    inexact: str
    corank: int

    def run(self) -> ProofOutcome:
        """The outcome of the proof."""
        plain = Proof(None, self.corank, reason=self.inexact)
        proof = plain if self.arm is None else certify_plain(self.arm, self.corank)
        return ProofOutcome.of(self.chain, self.arm, proof)


def run(piece: Chunk | ProofOf) -> Points | ProofOutcome:
    """The result of a piece."""
    return piece.run()


def run_together(pieces: Sequence[Chunk | ProofOf]) -> list[Points | ProofOutcome]:
    """The results of pieces that `together` has put together: the bits of each alone."""
    chunks = [piece for piece in pieces if isinstance(piece, Chunk)]
    if len(chunks) < 2:
        return [piece.run() for piece in pieces]
    sizes, rngs = [each.starts for each in chunks], [np.random.default_rng(each.seed) for each in chunks]
    return [*find_together(chunks[0].chain, chunks[0].corank, sizes, rngs, chunks[0].tolerance)]


def together(pieces: Sequence[Chunk | ProofOf]) -> list[list[Chunk | ProofOf]]:
    """The pieces in groups for one process: up to TOGETHER chunks that follow each other and differ by their starts."""
    groups: list[list[Chunk | ProofOf]] = []
    for piece in pieces:
        if groups and len(groups[-1]) < TOGETHER and _alike(piece, groups[-1][-1]):
            groups[-1].append(piece)
        else:
            groups.append([piece])
    return groups


def _alike(one: Chunk | ProofOf, other: Chunk | ProofOf) -> bool:
    """Whether both are chunks of one search by projection."""
    if not isinstance(one, Chunk) or not isinstance(other, Chunk) or one.method != "projection":
        return False
    return replace(one, starts=other.starts, seed=other.seed) == other
