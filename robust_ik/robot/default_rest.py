"""Default start configuration: zero, or near it if zero is singular. It uses arrays only."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robust_ik.checks import Array

SAMPLES = 32
"""Number of random configurations; the medians of their singular values are what is usual for an arm."""
SINGULAR, REGULAR = 0.01, 0.5
"""Fractions of the usual least singular value: below SINGULAR zero is singular, from REGULAR on a start is good."""
STEPS = (1, -1, 2, -2)
"""Displacements of a joint that are tried, in units of 45° or of a quarter of the arm's length scale."""
MARGIN = 0.05
"""Fraction of a joint's range that stays free at each end."""
FLOOR = 1e-4
"""Singular values below this fraction of the usual ones count as equal, so that rounding decides nothing."""
ROUNDS = 8
"""How often each joint is moved at most. Chosen: robots here need one to three moves in all."""
BETTER = 1e-6
"""Least increase of the score over an earlier trial: of mirrored postures, which are equal, the first is taken."""


def default_rest(jacobian: Callable[[Array], Array], lower: Array, upper: Array, unit: Array, samples: Array) -> Array:
    """Zero moved inside the limits, with a few joints bent if the tip has lost a motion there.

    Joints are bent one after the other, until the least singular value is half the usual one. Each time the joint and
    the displacement are taken that increase the singular values most.

    Args:
        jacobian: The tip's Jacobian in the arm's own unit of length, (m, n), from joint values (n,).
        lower: Lower limits, (n,).
        upper: Upper limits, (n,).
        unit: Unit of the displacement of each joint, rad or m, (n,).
        samples: Joint values of random configurations, (N, n).

    Returns:
        Joint values, (n,).
    """
    values: Array = np.clip(0.0, lower, upper)
    usual = _usual(jacobian, samples)
    sigma = _measured(jacobian, values)[: len(usual)]
    if not len(usual) or sigma[-1] >= SINGULAR * usual[-1]:
        return values
    for _ in range(ROUNDS * len(values)):
        if sigma[-1] >= REGULAR * usual[-1]:
            break
        trials = _trials(values, lower, upper, unit)
        found = [_measured(jacobian, trial)[: len(usual)] for trial in trials]
        best, score = -1, _score(sigma, usual)
        for index, each in enumerate(found):
            if _score(each, usual) > score + BETTER:
                best, score = index, _score(each, usual)
        if best < 0:
            break
        values, sigma = trials[best], found[best]
    return values


def _usual(jacobian: Callable[[Array], Array], samples: Array) -> Array:
    """Medians of the singular values over random configurations, without those that are always zero."""
    # Unlike np.median, it does not import numpy.ma.
    medians = np.quantile([_measured(jacobian, values) for values in samples], 0.5, axis=0)
    return np.asarray(medians[medians > FLOOR**2 * medians[0]])


def _measured(jacobian: Callable[[Array], Array], values: Array) -> Array:
    """The singular values of the Jacobian, descending."""
    return np.asarray(np.linalg.svd(jacobian(values), compute_uv=False))


def _trials(values: Array, lower: Array, upper: Array, unit: Array) -> list[Array]:
    """The joint values with one joint moved, well inside its limits."""
    spare = np.where(np.isfinite(upper - lower), MARGIN * (upper - lower), 0.0)
    found = []
    for joint in range(len(values)):
        for step in STEPS:
            trial = values.copy()
            trial[joint] += step * unit[joint]
            trial[joint] = np.clip(trial[joint], lower[joint] + spare[joint], upper[joint] - spare[joint])
            found.append(trial)
    return found


def _score(sigma: Array, usual: Array) -> float:
    """A score that is higher the nearer each singular value is to its usual value; larger values do not add to it."""
    return float(np.log(np.clip(sigma / usual, FLOOR, 1.0)).sum())
