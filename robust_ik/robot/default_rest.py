"""The configuration to start from where nobody states one: zero, or near it where zero is singular. Arrays only."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robust_ik.checks import Array

SAMPLES = 32
"""So many random configurations tell, by their median, what is usual of an arm."""
SINGULAR, REGULAR = 0.01, 0.5
"""Of the usual least singular value: what zero has when it counts as singular, what a start has when it is good."""
STEPS = (1, -1, 2, -2)
"""How far a joint is moved for a trial, in units of 45° or of a quarter of the arm's length scale."""
MARGIN = 0.05
"""The part of a joint's range that stays free at each end."""
FLOOR = 1e-4
"""Singular values below this part of the usual count as equal, so that rounding decides nothing."""
BETTER = 1e-6
"""What a trial must be better by than one before it: of mirrored postures, which are equal, the first is taken."""


def default_rest(jacobian: Callable[[Array], Array], lower: Array, upper: Array, unit: Array, samples: Array) -> Array:
    """Zero moved inside the limits, with a few joints bent where the tip has lost a motion there.

    Joints are bent one after the other, each time the one and as far as helps the singular values most, until the
    least is half of what it usually is.

    Args:
        jacobian: The tip's Jacobian in the arm's own unit of length, (m, n), from joint values (n,).
        lower: Lower limits, (n,).
        upper: Upper limits, (n,).
        unit: By what each joint is moved, rad or m, (n,).
        samples: Joint values of random configurations, (N, n).

    Returns:
        Joint values, (n,).
    """
    values: Array = np.clip(0.0, lower, upper)
    usual = _usual(jacobian, samples)
    sigma = _measured(jacobian, values)[: len(usual)]
    if not len(usual) or sigma[-1] >= SINGULAR * usual[-1]:
        return values
    for _ in values:
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
    medians = np.median([_measured(jacobian, values) for values in samples], axis=0)
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
    """Higher where every singular value is nearer to what it usually is; what is more than usual does not count."""
    return float(np.log(np.clip(sigma / usual, FLOOR, 1.0)).sum())
