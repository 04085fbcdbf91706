"""The verdict on a paper's claim, as a word that follows from the numbers and is never typed by hand."""

from __future__ import annotations

from collections.abc import Iterable

HOLDS, IN_KIND, WRONG, OPEN = "holds", "holds in kind", "wrong", "open"


def verdict(outcomes: bool | Iterable[bool | None] | None, *, stands_in: bool = False, cut: bool = False) -> str:
    """The verdict on a claim.

    ======================  =====================  ==================
    the claim               nothing stands in      something does
    ======================  =====================  ==================
    is true                 holds                  holds in kind
    is false                wrong                  open
    in some readings only   open                   open
    ======================  =====================  ==================

    Args:
        outcomes: Whether the numbers agree with the claim; one outcome for each reading, if the text can be read in
            several ways. None if the numbers do not decide.
        stands_in: Whether robot, path or settings are ours because the paper does not give them.
        cut: Whether our copy of the paper lacks the text of the claim.

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
