"""The length of a step of the gradient search: the one-dimensional search that eq. (11) asks for. Arrays only.

The paper chooses α "to achieve a maximum decrease" and searches "until a minimizer is found". It does not say how: each
way that its words allow is one of SEARCHES.

Source: Almarkhi-Maciejewski, section 2.2.1.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.svd import singular_values
from robust_ik.singularities.find.projection_search import LONGEST_STEP
from robust_ik.singularities.geometry.screw_chain import ScrewChain

LineSearch = Literal["grid", "exact", "nearest"]
SEARCHES = ("grid", "exact", "nearest")
"""The best length of a grid, the minimiser around the best one, and the first minimiser on the way."""

COARSE = 2.0 ** np.arange(2, -14, -1)
"""Lengths of steps to try, in units of the step that makes a linear σ zero."""
FINE = np.linspace(0.55, 1.9, 10)
"""Lengths to try next, in units of the best one."""
TREADS = np.linspace(0.0, COARSE[0], 51)
"""Lengths among which the first minimiser is bracketed.

Chosen: steps of a fiftieth of the longest one, 0.01 rad of the joint that moves most; more would take longer.
"""
GOLDEN = (np.sqrt(5) - 1) / 2
"""The golden section, of which the bracket of a minimiser keeps this part in each step."""
HALVINGS = 45
"""Steps of the golden section. Chosen: they shrink a bracket to 4e-10 of itself; more are below rounding of σ."""


def least_along(
    chain: ScrewChain, values: Array, corank: int, sigma: Array, directions: Array, search: LineSearch | None = "grid"
) -> tuple[Array, Array]:
    """The points along −directions with the least σ_{m−k+1}, and its values there; no step if it falls nowhere.

    Args:
        chain: What moves the tip.
        values: Joint values, (N, n).
        corank: k.
        sigma: σ_{m−k+1} there, (N,).
        directions: Gradients, (N, n).
        search: One of SEARCHES; None tries the lengths of COARSE alone.

    Returns:
        Joint values, (N, n), and σ_{m−k+1}, (N,).
    """
    squared = np.sum(directions**2, axis=1)
    unit = directions * (sigma / np.where(squared > 0, squared, 1.0))[:, None]
    longest = np.abs(unit).max(axis=1, keepdims=True)
    unit = unit * (LONGEST_STEP / COARSE[0] / np.maximum(longest, LONGEST_STEP / COARSE[0]))

    def along(lengths: Array) -> Array:
        """σ_{m−k+1} after steps of each length, (N, L)."""
        return target_values(chain, values[:, None] - lengths[..., None] * unit[:, None], corank)

    if search == "nearest":
        length, least = _golden(along, *_first_bracket(along(np.broadcast_to(TREADS, (len(values), len(TREADS))))))
    else:
        length, least = _best(along, np.broadcast_to(COARSE, (len(values), len(COARSE))))
        if search is not None:
            finer = (
                _golden(along, length / 2, length * 2) if search == "exact" else _best(along, length[:, None] * FINE)
            )
            better = finer[1] < least
            length, least = np.where(better, finer[0], length), np.where(better, finer[1], least)
    falls = least < sigma
    return np.where(falls[:, None], values - length[:, None] * unit, values), np.where(falls, least, sigma)


def target_values(chain: ScrewChain, values: Array, corank: int) -> Array:
    """σ_{m−k+1}, (..., n) → (...)."""
    return np.asarray(singular_values(chain.jacobian(values))[..., chain.full_rank - corank])


def _best(along: Callable[[Array], Array], lengths: Array) -> tuple[Array, Array]:
    """Of lengths (N, L) the one with the least σ, and this σ, (N,) each."""
    found, everything = along(lengths), np.arange(len(lengths))
    first = np.argmin(found, axis=1)
    return lengths[everything, first], found[everything, first]


def _first_bracket(sigmas: Array) -> tuple[Array, Array]:
    """The lengths on either side of the first one after which σ rises, from σ at TREADS, (N, L); else the last ones."""
    rises = sigmas[:, 1:] >= sigmas[:, :-1]
    last = len(TREADS) - 1
    first = np.where(rises.any(axis=1), np.argmax(rises, axis=1), last)
    return TREADS[np.maximum(first - 1, 0)], TREADS[np.minimum(first + 1, last)]


def _golden(along: Callable[[Array], Array], low: Array, high: Array) -> tuple[Array, Array]:
    """A minimiser between two lengths, (N,) each, by golden section, and σ there."""
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = along(left[:, None])[:, 0], along(right[:, None])[:, 0]
    for _ in range(HALVINGS):
        lower = at_left < at_right  # the minimiser is left of `right`
        low, high = np.where(lower, low, left), np.where(lower, right, high)
        new = np.where(lower, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
        at_new = along(new[:, None])[:, 0]
        left, right = np.where(lower, new, right), np.where(lower, left, new)
        at_left, at_right = np.where(lower, at_new, at_right), np.where(lower, at_left, at_new)
    return np.where(at_left < at_right, left, right), np.minimum(at_left, at_right)
