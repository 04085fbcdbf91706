"""The result of a step: what each level got, and the status."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.control.problem import VelocityProblem
from robust_ik.control.resolution import LevelResult, Resolution, Status
from robust_ik.control.within_bounds.null_space import Freedom, Reduced
from robust_ik.kinematics.svd import length

ZERO = 1e-6
"""Singular values below this fraction of the level's largest one count for its corank."""

NEAR = 0.05
"""A singularity is near if the smallest singular value is below this fraction of the largest."""

NOTHING = 1e-9
"""Task speeds below this count as zero, m/s or rad/s."""

MET = 1e-6
"""A wish is met if the residual is below this fraction of it."""

STUCK = 0.01
"""A level is stuck if it gets less than this fraction of its wish."""


def reductions(problem: VelocityProblem) -> tuple[Reduced, ...]:
    """Each level's Jacobian in the freedom left by the levels before."""
    freedom, found = Freedom.whole(len(problem.bounds.lower)), []
    for equation in problem.levels:
        found.append(freedom.reduce(equation.J))
        freedom = Freedom(found[-1].below)
    return tuple(found)


def verdict(problem: VelocityProblem, qdot: Array, scales: Sequence[float], reduced: Sequence[Reduced]) -> Resolution:
    """The resolution for joint velocities.

    Args:
        problem: The problem.
        qdot: The joint velocities, (n,).
        scales: The share of its motion that limits allow each level.
        reduced: Each level's Jacobian in the freedom left to it.
    """
    levels = tuple(
        _level(equation.xdot / problem.share - equation.J @ qdot, float(scale), each)
        for equation, scale, each in zip(problem.levels, scales, reduced)
    )
    return Resolution(
        qdot=readonly(qdot),
        levels=levels,
        active=problem.bounds.active(qdot),
        contradictions=problem.bounds.contradictions,
        status=_status(problem, levels),
        calmed=problem.share,
    )


def _level(residual: Array, scale: float, reduced: Reduced) -> LevelResult:
    """The result of one level."""
    own, left = reduced.own, reduced.s
    conditioned = len(own) > 0 and own[-1] > NEAR * own[0]
    lost = len(left) > 0 and left[-1] <= NEAR * own[0]
    return LevelResult(
        scale=scale,
        residual=residual,
        sigma=left,
        corank=int(np.sum(left <= ZERO * own[0])),
        kinematic_corank=int(np.sum(own <= ZERO * own[0])) if own[0] > 0 else len(own),
        algorithmic=bool(conditioned and lost),
    )


def _status(problem: VelocityProblem, levels: Sequence[LevelResult]) -> Status:
    if problem.bounds.contradictions:
        return Status.INFEASIBLE
    if not levels:
        return Status.TRACKING
    wanted = problem.levels[0].xdot / problem.share
    size, residual = length(wanted), levels[0].residual
    given = float((wanted / size) @ (wanted - residual)) if size > NOTHING else 0.0
    if size > NOTHING and given < STUCK * size:
        return Status.STUCK
    slowed = any(level.scale < 1 for level in levels)
    if slowed or length(residual) > max(MET * size, NOTHING):
        return Status.SCALED
    return Status.TRACKING
