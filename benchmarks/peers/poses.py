"""What scripts that invert poses share: restarts, limits, and how far a pose is from another. Needs NumPy only."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from timing import Work, error


def restarted(
    attempt: Callable[[np.ndarray, np.ndarray], np.ndarray],
    pose: Callable[[np.ndarray], np.ndarray],
    work: Work,
    tries: int = 100,
) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """A solver of poses from one that has no restarts or limits of its own: random starts until one attempt is right.

    Args:
        attempt: From (q0, target) to joint values.
        pose: From q to the tool's pose.
        work: Limits and tolerance.
        tries: How many starts, q0 included.

    Returns:
        From (q0, target) to joint values within the limits: the first right ones, else the nearest.
    """
    rng = np.random.default_rng(0)

    def solve(q: np.ndarray, target: np.ndarray) -> np.ndarray:
        best, least = q, np.inf
        for _ in range(tries):
            found = within(attempt(q, target), work)
            if found is not None:
                apart = error(pose(found), target)
                if (apart < work.tolerance).all():
                    return found
                if np.hypot(*apart) < least:
                    best, least = found, float(np.hypot(*apart))
            q = rng.uniform(work.lower, work.upper)
        return best

    return solve


def within(q: np.ndarray, work: Work) -> np.ndarray | None:
    """Joint values turned into the limits, or None where no whole turns do that."""
    turned = q - 2 * np.pi * np.ceil((q - work.upper - 1e-9) / (2 * np.pi))
    turned = np.where((q >= work.lower) & (q <= work.upper), q, turned)
    return turned if (turned >= work.lower - 1e-9).all() else None
