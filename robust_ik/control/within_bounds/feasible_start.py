"""The joint velocities from which a resolver starts: rest, or the last ones, or the closest within the bounds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.bounds import CONTRADICTION, Bounds
from robust_ik.control.within_bounds.active_set import minimum

PRICE = 0.1
"""Cost of motion relative to missing floors of unit rows: ½ PRICE ‖q̇ − near‖² against ½ Σ missing²."""
ROUNDS = 10
"""Number of rounds, in each of which the part still missing is asked for again."""
INSIDE = 1e-12
"""A row may be below its floor by this much, for rounding."""


def feasible_start(bounds: Bounds, near: Array | None = None) -> tuple[Array, Bounds]:
    """Joint velocities inside the bounds, and bounds for which they are inside.

    The box always holds. Compared with the point of the box closest to `near`, no row falls below its floor, or
    further below it. Rows below their floor are raised by a motion that has a cost, so that no motion is made that
    raises them by next to nothing. If a single row is below its floor, the fraction (1 + a²/PRICE)^−ROUNDS of what it
    misses remains, where a is the length of the unit row's part in the free joints: 4e-11 if all joints are free, 4e-6
    for a = 0.5, and nearly all below 0.05. Of several rows no more than PRICE ‖μ‖/√ROUNDS remains, where μ are the
    multipliers of the shortest change of q̇ that raises all of them to their floors, if there is one. The floor of a
    single row changes no joint velocity by more than 6.2 times the change of the unit row. Rows that miss their floor
    get the value that they reach as their floor, and are added to the contradictions.

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
    """Velocities close to `near` with the rows `below` close to their floors: some rounds of proximal multipliers."""
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
            [-unit[below], np.zeros((count, count))],
            [np.zeros((count, n)), -np.eye(count)],
        ]
    )
    worst = (unit @ qdot)[below]
    hessian, slope = np.diag(np.r_[np.full(n, PRICE), np.ones(count)]), np.r_[-PRICE * near, np.zeros(count)]
    asked, found, acting = floor.copy(), qdot, np.zeros(len(rows), dtype=bool)
    for _ in range(ROUNDS):
        room = np.concatenate([bounds.upper, -bounds.lower, -asked, -worst, np.zeros(count)])
        lacking = (asked - unit @ found)[below]
        acting[2 * n : 2 * n + len(floor)][below] = lacking > 0
        acting[-count:] = lacking <= 0
        finite = np.flatnonzero(np.isfinite(room))
        start, working = np.r_[found, np.maximum(lacking, 0.0)], np.flatnonzero(acting[finite])
        solution, held = minimum(hessian, slope, rows[finite], room[finite], start, working.tolist())
        acting[:] = False
        acting[finite[held]] = True
        found = np.clip(solution[:n], bounds.lower, bounds.upper)
        if (unit @ found >= floor - INSIDE)[below].all():
            break
        asked[below] = floor[below] + np.maximum(asked - unit @ found, 0.0)[below]
    return found
