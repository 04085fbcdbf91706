"""From the last velocities towards those that are wanted, as fast as acceleration limits allow.

Levels are resolved as if acceleration were free; then each level goes from the last velocities to what it was given,
the first level first. So a level that must wait goes on as it went, rather than to brake and to start again.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.bounds import Bounds
from robust_ik.control.fitting.feasible_start import feasible_start
from robust_ik.control.fitting.level_fit import Wish, slowed
from robust_ik.control.fitting.limiters import Limiter
from robust_ik.control.fitting.null_space import Freedom, Reduced


def ramped(
    aims: Sequence[Array], bounds: Bounds, limiter: Limiter, reduced: Sequence[Reduced]
) -> tuple[Array, list[float], tuple[str, ...]]:
    """Joint velocities on the way to the aim.

    Args:
        aims: What is wanted of each level and those above it, inside the bounds but for acceleration, (n,) each. No
            level sees what lower ones want, not even as rounding.
        bounds: All of them.
        limiter: How a level's motion is fitted in.
        reduced: The levels' Jacobians in what is left to each.

    Returns:
        q̇ inside the bounds, (n,); the share of its aim, or of the way to it if that is longer, that each level gets;
        limits that had to yield.
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
    # What no level asks for, each joint by itself would disturb the levels: all together.
    change, _ = slowed(Wish(qdot, freedom.project(aims[-1] - qdot), reduced[-1], freedom, bounds))
    return np.clip(qdot + change, bounds.lower, bounds.upper), shares, bounds.contradictions


def _share(J: Array, aim: Array, start: Array, qdot: Array) -> float:
    """How near q̇ is to the aim; all of it where what is missing is small beside the aim, however short the way."""
    size = max(float(np.linalg.norm(J @ aim)), float(np.linalg.norm(J @ (aim - start))))
    missing = float(np.linalg.norm(J @ (aim - qdot)))
    return max(0.0, 1 - missing / size) if size > 0 else 1.0


def _nearer(qdot: Array, change: Array, way: Array, level: Reduced, bounds: Bounds) -> Array:
    """The change, or every joint as far on the way as it can where that brings the level nearer to its aim.

    The first level need not spare others: so one joint that cannot brake harder does not keep the rest from braking.
    """
    each = np.clip(qdot + way, bounds.lower, bounds.upper) - qdot
    each = bounds.largest_step(qdot, each) * each
    missing = [float(np.linalg.norm(level.taken @ (way - tried))) for tried in (change, each)]
    return each if missing[1] < missing[0] else change
