"""Changes the last velocities towards the wanted ones, as fast as acceleration limits allow.

Levels are resolved as if acceleration were unlimited. Then each level goes from the last velocities to its result, the
first level first. So a level that must wait continues its motion instead of braking and starting again.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.bounds import Bounds
from robust_ik.control.within_bounds.feasible_start import feasible_start
from robust_ik.control.within_bounds.level_fit import Wish, slowed
from robust_ik.control.within_bounds.limiters import Limiter
from robust_ik.control.within_bounds.null_space import Freedom, Reduced

EVEN = 1 + 1e-12
"""A change that leaves more than another by no more than this factor leaves as much, for rounding."""


def ramped(
    aims: Sequence[Array], bounds: Bounds, limiter: Limiter, reduced: Sequence[Reduced]
) -> tuple[Array, list[float], tuple[str, ...]]:
    """Joint velocities on the way from the last ones to the aim.

    Args:
        aims: For each level the joint velocities resolved for it and the levels above, within the bounds except for
            acceleration, (n,) each. A lower level does not change them, not even by rounding.
        bounds: All bounds.
        limiter: The limiter.
        reduced: The levels' Jacobians in the freedom left to each.

    Returns:
        q̇ inside the bounds, (n,); the share of its aim that each level gets, or of the change to it if that is longer;
        limits that yielded.
    """
    qdot, bounds = feasible_start(bounds, bounds.last)
    freedom, shares = Freedom.whole(len(qdot)), []
    for index, (level, aim) in enumerate(zip(reduced, aims)):
        way, start = level.along(aim - qdot), qdot
        change, share = limiter.limit(Wish(qdot, way, level, freedom, bounds))
        if index == 0 and share < 1:
            change = _nearer(qdot, change, way, level, bounds)
        qdot = np.clip(qdot + change, bounds.lower, bounds.upper)
        shares.append(1.0 if share == 1 else _share(level.matrix, aim, start, qdot))
        freedom = Freedom(level.below)
    # Motion that no level asks for: joint by joint it would disturb the levels, so all joints change together.
    change, _ = slowed(Wish(qdot, freedom.project(aims[-1] - qdot), reduced[-1], freedom, bounds))
    return np.clip(qdot + change, bounds.lower, bounds.upper), shares, bounds.contradictions


def _share(J: Array, aim: Array, start: Array, qdot: Array) -> float:
    """The share of its aim that a level gets; 1 if the difference is small against the aim or the change to it."""
    size = max(float(np.linalg.norm(J @ aim)), float(np.linalg.norm(J @ (aim - start))))
    missing = float(np.linalg.norm(J @ (aim - qdot)))
    return max(0.0, 1 - missing / size) if size > 0 else 1.0


def _nearer(qdot: Array, change: Array, way: Array, level: Reduced, bounds: Bounds) -> Array:
    """The change, or the change of every joint by itself if that brings the level nearer to its aim.

    The first level need not spare others. So one joint that cannot brake harder does not keep the rest from braking.
    """
    each = np.clip(qdot + way, bounds.lower, bounds.upper) - qdot
    each = bounds.largest_step(qdot, each) * each
    missing = [float(np.linalg.norm(level.taken @ (way - tried))) for tried in (change, each)]
    return each if missing[1] <= missing[0] * EVEN else change
