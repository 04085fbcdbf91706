"""The word for what became of a paper's claim: it follows from what the numbers say of it, and nobody types it."""

from __future__ import annotations

from collections.abc import Iterable

HOLDS, IN_KIND, WRONG, OPEN = "holds", "holds in kind", "wrong", "open"


def verdict(outcomes: bool | Iterable[bool | None] | None, *, stands_in: bool = False, cut: bool = False) -> str:
    """What became of a claim.

    ======================  =====================  ==================
    what the claim says     nothing stands in      something does
    ======================  =====================  ==================
    is so                   holds                  holds in kind
    is not so               wrong                  open
    in some readings only   open                   open
    ======================  =====================  ==================

    Args:
        outcomes: Whether the numbers are as the claim says; one outcome for each reading, where the text can be read
            in several ways. None says that the numbers do not decide.
        stands_in: Robot, path or settings are ours, as the paper does not tell them.
        cut: Our copy of the paper lacks what the claim says.

    Raises:
        ValueError: There is no outcome.
    """
    found = set(outcomes) if isinstance(outcomes, Iterable) else {outcomes}
    if not found:
        raise ValueError("a verdict needs at least one outcome, none is given")
    if cut or None in found or len(found) > 1:
        return OPEN
    if found.pop():
        return IN_KIND if stands_in else HOLDS
    return OPEN if stands_in else WRONG
