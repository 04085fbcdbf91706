"""Tunes a contender on the training half of the arms: the setting of the lowest price among a few random ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from benchmarks.robustness.arms import TRAINING
from benchmarks.robustness.contenders import TRIES, Contender, drawn
from robust_ik.simulation.robustness import RunKey, RunScore, means_of, price

Measured = Callable[[Contender, str], Mapping[RunKey, RunScore]]
"""From a contender and the name of an arm to its scores on the scenarios for tuning."""


def tuned(contender: Contender, measure: Measured, tries: int = TRIES) -> tuple[Contender, float]:
    """The contender at the best setting of those drawn and its defaults, and the price there.

    Args:
        contender: With its defaults.
        measure: Scores on the training half; nothing else is asked for.
        tries: Settings beside the defaults.
    """
    settings = drawn(contender, tries)
    prices = [price_of(contender, measure), *(price_of(contender.set_to(each), measure) for each in settings)]
    best = min(range(len(prices)), key=prices.__getitem__)
    return contender.set_to(settings[best - 1] if best else {}), prices[best]


def price_of(contender: Contender, measure: Measured, arms: Sequence[str] = TRAINING) -> float:
    """The price of a contender on some arms."""
    scores: dict[RunKey, RunScore] = {}
    for name in arms:
        scores |= measure(contender, name)
    return price(means_of(scores))
