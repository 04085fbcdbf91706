"""Solves a quadratic program over joint velocities within bounds, exactly at the bounds that act."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.bounds import Bounds
from robust_ik.control.within_bounds.active_set import minimise
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import least_norm_solution

REGULARISATION = 1e-9
"""Weight of motions that no task sees, relative to motions that one sees."""

INSIDE = 1e-12
"""A solution may lie outside the bounds by this much, for rounding."""

ON_BOUND = 1e-6
"""Constraints this close to their bound in the solver's answer are taken as acting."""

ALL_BUT = 1e-6
"""A share closer to 1 than this counts as 1."""

SETTINGS: dict[str, dict[str, Any]] = {
    "daqp": {"primal_tol": 1e-10, "dual_tol": 1e-10},
    "proxqp": {"eps_abs": 1e-10},
    "quadprog": {},
}
"""Settings of solvers, tighter than their defaults; other solvers get their defaults."""


def check_backend(backend: str) -> None:
    """Raises if a solver is not installed.

    Raises:
        InputError: It is not; the message lists the installed ones.
    """
    import qpsolvers  # imports scipy, a quarter of a second: only if a program is solved

    if not isinstance(backend, str) or backend not in qpsolvers.available_solvers:
        raise InputError(f"backend must be one of {', '.join(sorted(qpsolvers.available_solvers))}, got {backend!r}")


def solve_within(
    hessian: Array, slope: Array, directions: Array, bounds: Bounds, qdot: Array, backend: str | None
) -> Array:
    """The y that minimises ½ yᵀ H y + gᵀ y with q̇ + D y inside the bounds.

    The solver finds which bounds act. From its solution an active-set method goes on to the exact minimum; if the
    solver fails, as it may for locked joints or huge wishes, it starts from y = 0. So the answer does not depend on the
    solver.

    Args:
        hessian: H, (d, d), positive definite.
        slope: g, (d,).
        directions: D, (n, d).
        bounds: The bounds.
        qdot: q̇, inside the bounds, (n,).
        backend: A solver that qpsolvers knows; None to start from y = 0.

    Returns:
        y, (d,), exact at the bounds that act.
    """
    if directions.shape[1] == 0:
        return np.zeros(0)
    rows, room = _constraints(directions, bounds, qdot)
    guess = None if backend is None else _guess(hessian, slope, rows, room, backend)
    acting = [] if guess is None else _independent(rows, np.flatnonzero(room - rows @ guess <= ON_BOUND))
    start = None if guess is None else _on(rows[acting], room[acting], guess)
    if start is None or (rows @ start > room + INSIDE).any():
        return minimise(hessian, slope, rows, room, np.zeros(len(slope)))
    return minimise(hessian, slope, rows, room, start, acting)


def share_of(wanted: Array, given: Array) -> float:
    """The share of a wish that is given, along it, in [0, 1]; 1 if only the cost of regularisation is missing."""
    largest = float(np.abs(wanted).max(initial=0.0)) or 1.0  # squares could overflow without it
    wanted, given = wanted / largest, given / largest
    size = float(wanted @ wanted)
    share = float(np.clip(wanted @ given / size, 0.0, 1.0)) if size > 0 else 1.0
    return 1.0 if share > 1 - ALL_BUT else share


def _constraints(directions: Array, bounds: Bounds, qdot: Array) -> tuple[Array, Array]:
    """Rows and room with rows y ≤ room; room is never negative, so that y = 0 is inside."""
    rows = np.concatenate([directions, -directions, -(bounds.rows @ directions)])
    room = np.concatenate([bounds.upper - qdot, qdot - bounds.lower, bounds.rows @ qdot - bounds.floor])
    kept = np.isfinite(room)
    return rows[kept], np.maximum(room[kept], 0.0)


def _guess(hessian: Array, slope: Array, rows: Array, room: Array, backend: str) -> Array | None:
    """The solver's answer, or None."""
    import qpsolvers  # as above

    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")  # solvers report a failure by a warning
        try:
            y = qpsolvers.solve_qp(hessian, slope, rows, room, solver=backend, **SETTINGS.get(backend, {}))
        except Exception:
            return None
    return None if y is None or not np.isfinite(y).all() else np.asarray(y, dtype=float)


def _on(rows: Array, room: Array, y: Array) -> Array | None:
    """The point closest to y on the bounds of the rows; None if the rows depend on each other."""
    lengths = np.linalg.norm(rows, axis=1)
    change = least_norm_solution(rows / lengths[:, None], (room - rows @ y) / lengths)
    return None if change is None else y + change


def _independent(rows: Array, candidates: NDArray[np.intp]) -> list[int]:
    """Candidates whose rows are independent of the earlier ones."""
    chosen: list[int] = []
    for index in candidates:
        trial = rows[[*chosen, index]]
        lengths = np.linalg.norm(trial, axis=1)
        if lengths.min() > 1e-9 and least_norm_solution(trial / lengths[:, None], np.zeros(len(trial))) is not None:
            chosen.append(int(index))
    return chosen
