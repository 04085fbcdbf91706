"""The same searches as in `projection_search`, all their steps in one call of compiled code. Arrays only."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from robust_ik.checks import Array
from robust_ik.kernels.search import corank_search_layout
from robust_ik.singularities.geometry.screw_chain import ScrewChain

LARGEST = 16
"""Chains with more joints are searched by NumPy: the largest kernel is `corank_search.searches_16`."""


class Rules(NamedTuple):
    """The rules of a search, see `projection_search`, in the order of `corank_search_layout`."""

    tolerance: float
    steps: int
    longest: float
    first: float
    less: float
    more: float
    worthwhile: float
    patience: int


AT_ONCE = Rules(0.0, 0, 1.0, 1.0, 1.0, 1.0, 1.0, 0)
"""Those of a search that ends where it starts."""


class Ends(NamedTuple):
    """The ends of N searches: joint values (N, n), `s`, `derivative` and `scale` of the `Residual`, tries (N,)."""

    values: Array
    s: Array
    derivative: Array
    scale: Array
    tries: Array


def compiled_search(chain: ScrewChain, corank: int, values: Array, rules: Rules) -> Ends | None:
    """Searches from joint values (N, n) for a corank; None if NumPy has to.

    That is for more joints than compiled code takes, or if the joint values are not fit: NumPy then says why.
    """
    m, n, kept, count = chain.m, chain.n, chain.full_rank - corank, len(values)
    if not (max(m, n) <= LARGEST and 0 <= kept < min(m, n) and values.shape == (count, n)):
        return None
    a, b = m - kept, n - kept
    ends = Ends(
        np.array(values, dtype=float, order="C"),
        np.empty((count, min(m, n))),
        np.empty((count, a * b, n)),
        np.empty(count),
        np.empty(count),
    )
    told = np.array((*rules, chain.least_scale))
    room = np.empty(corank_search_layout.room(m, n, a, b))
    found = _kernel(max(m, n) <= 8)(chain.joints.packed, chain.task, told, kept, room, *ends)
    return ends if found else None


@cache
def _kernel(small: bool) -> Callable[..., bool]:
    """The kernel for at most 8, or else LARGEST, rows and joints."""
    from robust_ik.kernels import search

    compiled: Callable[..., bool] = getattr(search, f"searches_{8 if small else LARGEST}").compiled
    return compiled
