"""Many targets in pieces, one after the other, on threads, or wherever an executor does them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from robust_ik.checks import Array
from robust_ik.errors import InputError
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.runtime.parallel import run_pieces

if TYPE_CHECKING:
    from robust_ik.pose_ik.solver import PoseSolver

PIECE = 1024
"""Targets in a piece: the same whatever does them."""

Done = tuple[Array, Array]


class Piece(NamedTuple):
    """Some targets."""

    targets: Array
    q0: Array
    options: Array
    solutions: int


def cut(targets: Array, q0: Array, options: Array, solutions: int) -> list[Piece]:
    """Targets (N, 4, 4) with q0 (N, nq) or (1, nq), in pieces."""
    return [
        Piece(targets[i : i + PIECE], q0 if len(q0) == 1 else q0[i : i + PIECE], options, solutions)
        for i in range(0, len(targets), PIECE)
    ]


def solve_piece(solver: PoseSolver, piece: Piece) -> Done:
    """Solutions (N, s, nq) and numbers of one piece."""
    from robust_ik.kernels.pose.pose_search import solve_many  # imports Numba, half a second: only where it is needed

    wanted, count = int(piece.options[lay.WANTED]), len(piece.targets)
    q, numbers = np.full((count, wanted, solver.chain.nq), np.nan), np.empty((count, lay.NUMBERS))
    targets, q0 = np.ascontiguousarray(piece.targets), np.ascontiguousarray(piece.q0)
    solve_many.compiled(solver.problem, piece.options, targets, q0, q, numbers)
    return q[:, : piece.solutions], numbers


def run(
    solver: PoseSolver,
    pieces: Sequence[Piece],
    threads: int,
    executor: Executor | None,
    progress: Callable[[int, int], None] | None,
) -> list[Done]:
    """The results of all pieces, in their order.

    Raises:
        InputError: `threads` is no count.
    """
    if isinstance(threads, bool) or not isinstance(threads, (int, np.integer)) or threads < 1:
        raise InputError(f"threads must be a whole number of at least 1, got {threads!r}")
    work = partial(solve_piece, solver)
    if executor is not None or threads == 1 or len(pieces) < 2:
        return run_pieces(work, pieces, executor, progress)
    solver.problem  # noqa: B018 - made once, before threads ask for it
    with ThreadPoolExecutor(int(threads)) as pool:
        return run_pieces(work, pieces, pool, progress)
