"""Solutions that differ by full turns of joints. Arrays only."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.errors import InputError

MOST_TURNED = 100_000
"""Most solutions with turns. Chosen: eight of a UR have 512; what nobody looks through shall not fill the memory."""
AT_LIMIT = 1e-9
"""By how much a joint may pass its limit, rad."""


def with_turns(
    values: Array, lower: Array, upper: Array, turning: NDArray[np.bool_]
) -> tuple[Array, NDArray[np.int_]]:  # fmt: skip
    """Joint values with every full turn that stays within limits, those with the fewest turns first of each.

    Args:
        values: Solutions, (s, n).
        lower: Limits, (n,).
        upper: The same.
        turning: Joints that may turn by 2π, between finite limits, (n,).

    Returns:
        The values, (t, n), and which solution each comes from, (t,).

    Raises:
        InputError: There are more than MOST_TURNED.
    """
    made: list[Array] = []
    source: list[int] = []
    for place, q in enumerate(values):
        low = np.where(turning, np.ceil((lower - AT_LIMIT - q) / (2 * np.pi)), 0)
        high = np.where(turning, np.floor((upper + AT_LIMIT - q) / (2 * np.pi)), 0)
        count = math.prod(int(each) for each in high - low + 1)
        if len(made) + count > MOST_TURNED:
            raise InputError(f"with turns there are more than {MOST_TURNED} solutions; give narrower limits")
        turns = np.array(list(itertools.product(*(np.arange(a, b + 1) for a, b in zip(low, high)))))
        order = np.argsort(np.abs(turns).sum(axis=1), kind="stable")
        made += list(np.where(turning, np.clip(q + 2 * np.pi * turns[order], lower, upper), q))
        source += [place] * count
    return np.array(made).reshape(-1, values.shape[-1]), np.array(source, dtype=int)
