"""Spread: what a measurement gives when it is begun a hair's breadth away, again and again.

Where an experiment is chaotic, or ends in rounding, its digits are the machine's and not the method's. Such a number is
measured from several starts and shown as a range.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Spread:
    """The values that one quantity took.

    It prints as a range, `f"{spread:.2g}"` gives "4.1 to 5.6", or as one number where both ends print the same.

    Attributes:
        runs: One value for each start.
    """

    runs: tuple[float, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "runs", tuple(float(each) for each in self.runs))

    @property
    def low(self) -> float:
        """The least."""
        return min(self.runs)

    @property
    def high(self) -> float:
        """The largest."""
        return max(self.runs)

    @property
    def median(self) -> float:
        """The one in the middle."""
        return float(np.median(self.runs))

    def __format__(self, form: str) -> str:
        low, high = format(self.low, form), format(self.high, form)
        return low if low == high else f"{low} to {high}"

    def near(self, other: Spread) -> bool:
        """Whether the two ranges overlap, each made twice as wide on either side."""
        gap = max(self.low, other.low) - min(self.high, other.high)
        return gap <= max(self.high - self.low, other.high - other.low)


def spread(
    measure: Callable[[np.ndarray], Any], start: Sequence[float] | np.ndarray, amount: float = 1e-12, count: int = 5
) -> Any:
    """What `measure` gives from a start, and from `count` starts that differ from it by `amount`.

    Feedback lets such a difference fade: where a path leads through a singularity exactly, how near a step comes to it
    is up to rounding all the same, and the spread is too narrow. State a bound there.

    Args:
        measure: From a start, (n,), to a number, or to a mapping of names to numbers.
        start: Where the experiment begins, (n,).
        amount: Largest difference of an entry: far below what any experiment fixes, far above rounding.
        count: How many further starts.

    Returns:
        A `Spread`; a dictionary of them if `measure` gives a mapping.
    """
    rng, begin = np.random.default_rng(0), np.asarray(start, float)
    others = begin + rng.uniform(-amount, amount, (count, *begin.shape))
    found = [measure(each) for each in (begin, *others)]
    if isinstance(found[0], Mapping):
        return {name: Spread(tuple(each[name] for each in found)) for name in found[0]}
    return Spread(tuple(found))
