"""Which methods no other one beats: the Pareto front of several numbers, of which less is better."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors import InputError

SAME = 1e-6
"""Numbers that differ by less than this part of them are the same, so that rounding beats nobody."""


def dominated_by(values: Mapping[str, Sequence[float]]) -> dict[str, tuple[str, ...]]:
    """For each method the others that are no worse in any number and better in one: () for those on the front.

    Args:
        values: The numbers by method, the same ones in the same order; less is better.

    Raises:
        InputError: Methods have different counts of numbers, or one has a number that is nan.
    """
    names = list(values)
    if len({len(each) for each in values.values()}) > 1:
        raise InputError("every method needs the same numbers to be compared with others")
    table = np.array([values[name] for name in names], dtype=float).reshape(len(names), -1)
    if np.isnan(table).any():
        missing = [name for name, row in zip(names, table) if np.isnan(row).any()]
        raise InputError(f"numbers are missing of {', '.join(missing)}")
    beats = better(table)
    return {name: tuple(names[i] for i in np.flatnonzero(beats[:, j])) for j, name in enumerate(names)}


def better(table: Array) -> Array:
    """Whether row i of numbers, (..., M, K), dominates row j: (..., M, M) of bool."""
    first, second = table[..., :, None, :], table[..., None, :, :]
    no_worse, less = first <= second * (1 + SAME), first < second * (1 - SAME)
    return np.asarray(no_worse.all(axis=-1) & less.any(axis=-1))
