"""The configuration to start from where nobody states one: zero, or near it where zero is singular."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.twist_rows import ROWS

if TYPE_CHECKING:
    from robust_ik.robot.robot import Robot

SAMPLES = 32
"""Random configurations whose median tells what is usual of an arm."""
SINGULAR, REGULAR = 0.01, 0.5
"""Of the usual least singular value: what zero has when it counts as singular, what a start has when it is good."""
TURNS, SLIDES = np.array([1, -1, 2, -2]) * np.pi / 4, np.array([1, -1, 2, -2]) / 4
"""How far a joint is moved for a trial, rad, and m times the arm's length scale."""
MARGIN = 0.05
"""The part of a joint's range that stays free at each end."""
FLOOR = 1e-4
"""Singular values below this part of the usual count as equal, so that rounding decides nothing."""
BETTER = 1e-6
"""What a trial must be better by than one before it: of mirrored postures, which are equal, the first is taken."""


def default_rest(robot: Robot) -> Array:
    """Zero moved inside the limits, (nq,), with a few joints bent where the tip has lost a motion there.

    Joints are bent one after the other, each time the one and as far as helps the singular values most, until the
    least is half of what it usually is. A robot without a tip starts at zero.
    """
    values = np.clip(0.0, robot.lower, robot.upper)
    if robot.tip is None:
        return robot.configuration(values)
    usual = _usual(robot)
    sigma = _measured(robot, values, len(usual))
    if not len(usual) or sigma[-1] >= SINGULAR * usual[-1]:
        return robot.configuration(values)
    for _ in range(robot.n):
        if sigma[-1] >= REGULAR * usual[-1]:
            break
        trials = _trials(robot, values)
        found = [_measured(robot, trial, len(usual)) for trial in trials]
        best, score = -1, _score(sigma, usual)
        for index, each in enumerate(found):
            if _score(each, usual) > score + BETTER:
                best, score = index, _score(each, usual)
        if best < 0:
            break
        values, sigma = trials[best], found[best]
    return robot.configuration(values)


def _usual(robot: Robot) -> Array:
    """Medians of the singular values over random configurations, without those that are always zero."""
    rng = np.random.default_rng(0)
    found = np.array([_measured(robot, robot.joint_values(q), None) for q in robot.random(rng, SAMPLES)])
    medians = np.median(found, axis=0)
    return np.asarray(medians[medians > FLOOR**2 * medians[0]])


def _measured(robot: Robot, values: Array, count: int | None) -> Array:
    """The first singular values of the tip's Jacobian in the arm's own unit of length, descending."""
    J = robot.jacobian(robot.configuration(values))
    scale = np.array([1.0 if row in ROWS[:3] else robot.length_scale for row in robot.rows])
    return np.asarray(np.linalg.svd(scale[:, None] * J, compute_uv=False)[:count])


def _trials(robot: Robot, values: Array) -> list[Array]:
    """The joint values with one joint moved, well inside its limits."""
    low, high = robot.lower, robot.upper
    spare = np.where(np.isfinite(high - low), MARGIN * (high - low), 0.0)
    found = []
    for joint, slides in enumerate(robot.sliding):
        for step in SLIDES * robot.length_scale if slides else TURNS:
            trial = values.copy()
            trial[joint] = np.clip(values[joint] + step, low[joint] + spare[joint], high[joint] - spare[joint])
            found.append(trial)
    return found


def _score(sigma: Array, usual: Array) -> float:
    """Higher where every singular value is nearer to what it usually is; what is more than usual does not count."""
    return float(np.log(np.clip(sigma / usual, FLOOR, 1.0)).sum())
