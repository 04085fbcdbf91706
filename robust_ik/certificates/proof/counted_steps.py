"""What a check may take, counted in steps, so that a certificate made to keep the checker busy is refused."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

MOST = 30_000_000
"""Steps of a check, some five seconds; proofs of the arms that are known take up to 6,400,000."""


class TooManyStepsError(Exception):
    """A check that would take more steps than it may."""


class _Left(threading.local):
    steps: float = float("inf")


_LEFT = _Left()


@contextmanager
def at_most(steps: float) -> Iterator[None]:
    """What is done inside may take so many steps, each about a tenth of a microsecond of a machine's time."""
    before, _LEFT.steps = _LEFT.steps, steps
    try:
        yield
    finally:
        _LEFT.steps = before


def spend(steps: float) -> None:
    """Counts steps that are about to be taken.

    Raises:
        TooManyStepsError: There are not so many left.
    """
    _LEFT.steps -= steps
    if _LEFT.steps < 0:
        raise TooManyStepsError("it takes more steps than a check may take")


def left() -> float:
    """How many are left; without bound, infinitely many."""
    return _LEFT.steps
