"""Counts the steps of a check, so that a certificate made to keep the checker busy is refused."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

MOST = 30_000_000
"""Most steps of a check, some five seconds; proofs of known arms take up to 6,400,000."""


class TooManyStepsError(Exception):
    """A check would take more steps than allowed."""


class _Left(threading.local):
    steps: float = float("inf")


_LEFT = _Left()


@contextmanager
def at_most(steps: float) -> Iterator[None]:
    """Limits the code inside to so many steps, each about a tenth of a microsecond of a machine's time."""
    before, _LEFT.steps = _LEFT.steps, steps
    try:
        yield
    finally:
        _LEFT.steps = before


def spend(steps: float) -> None:
    """Subtracts steps that are about to be taken.

    Raises:
        TooManyStepsError: Fewer are left.
    """
    _LEFT.steps -= steps
    if _LEFT.steps < 0:
        raise TooManyStepsError("it takes more steps than a check may take")


def left() -> float:
    """Steps left; infinite without a limit."""
    return _LEFT.steps
