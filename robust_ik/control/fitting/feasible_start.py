"""Where a resolver starts: at rest, or at the last velocities, or as near to them as bounds allow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.bounds import CONTRADICTION, Bounds
from robust_ik.control.fitting.active_set import minimum

PRICE = 0.1
"""Price of motion against what is missing at unit rows: ½ PRICE ‖q̇ − near‖² against ½ Σ missing²."""
ROUNDS = 10
"""How often what is still missing is asked for again, on top of what was."""
INSIDE = 1e-12
"""How far below its floor a row may be: rounding."""


def feasible_start(bounds: Bounds, near: Array | None = None) -> tuple[Array, Bounds]:
    """Joint velocities inside the bounds, and bounds that have them inside.

    The box always holds, and no row goes below its floor, or further below it, than where the box is nearest. Rows
    below are brought towards their floor by a motion that has its price, so that none is made that brings next to
    nothing: of what a single row misses there remains the share (1 + a²/PRICE)^−ROUNDS, where a is the length of what
    free joints have of the unit row. That is 4e-11 where all are free, 4e-6 for a = 0.5, and nearly all below 0.05.
    Of several rows there remains no more than PRICE ‖μ‖/√ROUNDS, μ being the multipliers of the shortest change of q̇
    that brings all of them to their floors, if there is one. A single row's floor changes no joint velocity by more
    than 6.2 times what it changes of the unit row. Rows that miss their floor get the one that they do reach, and are
    added to the contradictions.

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
    """Velocities near some with the rows `below` near their floor: a proximal method of multipliers of few rounds."""
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
