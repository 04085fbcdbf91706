"""Where a resolver starts: at rest, or at the last velocities, or as near to them as bounds allow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robust_ik.bounds import CONTRADICTION, Bounds
from robust_ik.checks import Array
from robust_ik.resolvers.active_set import minimise

NEAREST = 1e-6
"""Price of being far against that of missing a floor: so low that no floor is missed for it."""


def feasible_start(bounds: Bounds, near: Array | None = None) -> tuple[Array, Bounds]:
    """Joint velocities inside the bounds, and bounds that have them inside.

    The box always holds, and so do rows that hold where the box is nearest. The others are brought to their
    floor wherever that is possible together; where it is not, the sum of what is missing is the least possible. Rows
    that miss their floor get the one that they do reach, and are added to the contradictions.

    Returns:
        q̇, (n,), and the bounds.
    """
    near = np.zeros(len(bounds.lower)) if near is None else near
    qdot = np.clip(near, bounds.lower, bounds.upper)
    below = bounds.rows @ qdot < bounds.floor - CONTRADICTION / 2
    if not below.any():
        return qdot, bounds
    qdot = _raised(bounds, below, qdot, near)
    reached = bounds.rows @ qdot
    short = reached < bounds.floor - CONTRADICTION / 2
    names = tuple(cause for cause, yields in zip(bounds.row_cause, short) if yields)
    return qdot, replace(bounds, floor=np.minimum(bounds.floor, reached), contradictions=bounds.contradictions + names)


def _raised(bounds: Bounds, below: NDArray[np.bool_], qdot: Array, near: Array) -> Array:
    """The velocities nearest to some with the rows `below` at their floor, or least below it in sum."""
    n, count = len(qdot), int(below.sum())
    lengths = np.linalg.norm(bounds.rows, axis=1)
    lengths = np.where(lengths > 0, lengths, 1.0)
    unit, floor = bounds.rows / lengths[:, None], bounds.floor / lengths
    floor = np.where(below, floor, np.minimum(floor, unit @ qdot))
    missing = np.zeros((len(floor), count))
    missing[below] = np.eye(count)
    rows = np.block(
        [
            [np.eye(n), np.zeros((n, count))],
            [-np.eye(n), np.zeros((n, count))],
            [-unit, -missing],
            [np.zeros((count, n)), -np.eye(count)],
        ]
    )
    room = np.concatenate([bounds.upper, -bounds.lower, -floor, np.zeros(count)])
    finite = np.isfinite(room)
    found = minimise(
        NEAREST * np.eye(n + count),
        np.r_[-NEAREST * near, np.ones(count)],
        rows[finite],
        room[finite],
        np.r_[qdot, (floor - unit @ qdot)[below]],
    )
    return np.clip(found[:n], bounds.lower, bounds.upper)
