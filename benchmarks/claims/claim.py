"""Claim: one statement of a paper, and what became of it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Claim:
    """One line of the page.

    Attributes:
        what: What is claimed, with its place in the paper.
        paper: The paper's number or words.
        ours: The number that the same experiment gives here, measured just now.
        verdict: "holds", "holds in kind" (with stand-ins for what the paper does not say), "wrong" or "open".
        why: One line.
    """

    what: str
    paper: str
    ours: str
    verdict: str
    why: str
