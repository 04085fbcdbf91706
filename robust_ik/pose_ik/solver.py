"""PoseSolver: inverse kinematics of one frame in some rows, prepared once. Arrays only."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.chain import Chain
from robust_ik.checks import Array, check_leading_axes
from robust_ik.errors import InputError
from robust_ik.kernels import pose_layout as lay
from robust_ik.linalg import singular_values
from robust_ik.pose_ik.batch import cut, run
from robust_ik.pose_ik.inputs import as_pose, as_poses, as_start, as_starts, plain, refuse
from robust_ik.pose_ik.options import Effort, Prefer, pack_options
from robust_ik.pose_ik.packing import pack
from robust_ik.pose_ik.result import PoseResult, PoseResults, SeveralSolutions
from robust_ik.rows import ROWS

POSITION_TOLERANCE, ROTATION_TOLERANCE = 1e-8, 1e-8

LENGTH_SCALE, APART = 1.0, 0.1
USUAL = ("nearest", 1, "normal", POSITION_TOLERANCE, ROTATION_TOLERANCE, LENGTH_SCALE, APART)
MOST_KEPT = 64
"""Sets of options that a solver keeps as kernels read them."""


@dataclass(frozen=True, eq=False)
class PoseSolver:
    """Inverts the pose of a frame, in some rows, inside joint limits; `Robot.pose_solver` makes it.

    Damped least squares with an active set of limits from q0, then from a table of configurations whose poses are near,
    then from random ones; each start is given up as soon as it falls behind. Where nothing reaches the target, the best
    are polished by Newton's method. The same input gives the same bits, one by one, in batches and on threads.

    Attributes:
        chain: What moves the frame.
        lower: Of the n joints, rad or m.
        upper: The same.
        rest: Where a search begins without a q0, (nq,).
        rows: Wanted rows, of x y z wx wy wz.
    """

    chain: Chain
    lower: Array
    upper: Array
    rest: Array
    rows: tuple[str, ...]

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.chain, self.lower, self.upper, self.rest, self.rows)

    @cached_property
    def problem(self) -> Array:
        """What kernels read, with the table of starts."""
        return pack(self.chain, self.lower, self.upper, self.rows)

    @cached_property
    def _setups(self) -> dict[Any, Setup]:
        return {}

    @cached_property
    def _kernel(self) -> Callable[..., Any]:
        from robust_ik.kernels.pose_search import solve_one  # imports Numba, half a second: only where it is needed

        return solve_one.compiled

    @cached_property
    def quickly(self) -> Callable[[Any, Any], PoseResult | None]:
        """`solve` where nothing is said of options, half a microsecond faster; None unless given arrays of doubles."""
        setup = Setup(self.problem, pack_options(*USUAL, seed=0))
        kernel, rest, nq, empty = self._kernel, self.rest, len(self.rest), np.empty

        def solve(target: Any, q0: Any) -> PoseResult | None:
            q, numbers = empty(nq), empty(lay.NUMBERS)
            if kernel(setup.address, target, rest if q0 is None else q0, q, numbers):
                return PoseResult(q, numbers, self)
            return None

        return solve

    def solve(
        self,
        target: ArrayLike,
        q0: ArrayLike | None = None,
        *,
        prefer: Prefer = "nearest",
        solutions: int = 1,
        effort: Effort = "normal",
        position_tolerance: float = POSITION_TOLERANCE,
        rotation_tolerance: float = ROTATION_TOLERANCE,
        length_scale: float = LENGTH_SCALE,
        apart: float = APART,
        rng: np.random.Generator | None = None,
    ) -> PoseResult:
        """A configuration at a target; see `Robot.solve_pose`."""
        setup = self._prepared(
            prefer, solutions, effort, position_tolerance, rotation_tolerance, length_scale, apart, rng
        )
        T, start = as_pose(target), self.rest if q0 is None else as_start(q0, self.rest)
        q, numbers = np.empty((setup.wanted, len(self.rest))), np.empty(lay.NUMBERS)
        if not self._kernel(setup.address, T, start, q, numbers):
            # Another type of number or layout, or what cannot be meant.
            T, start = as_pose(plain(target, "target")), as_start(plain(start, "q0"), self.rest)
            if not self._kernel(setup.address, T, start, q, numbers):
                refuse(T, start, self.rest)
        if setup.wanted == 1:
            return PoseResult(q[0], numbers, self)
        return SeveralSolutions(q[: min(max(int(numbers[lay.FOUND]), 1), int(solutions))], numbers, self)

    def solve_many(
        self,
        targets: ArrayLike,
        q0: ArrayLike | None = None,
        *,
        prefer: Prefer = "nearest",
        solutions: int = 1,
        effort: Effort = "normal",
        position_tolerance: float = POSITION_TOLERANCE,
        rotation_tolerance: float = ROTATION_TOLERANCE,
        length_scale: float = LENGTH_SCALE,
        apart: float = APART,
        rng: np.random.Generator | None = None,
        threads: int = 1,
        executor: Executor | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> PoseResults:
        """Configurations at many targets; see `Robot.solve_poses`."""
        options = self._prepared(
            prefer, solutions, effort, position_tolerance, rotation_tolerance, length_scale, apart, rng
        ).options
        T, start = as_poses(targets), as_starts(self.rest if q0 is None else q0, self.rest)
        shape = T.shape[:-2]
        check_leading_axes("targets", shape, "q0", start.shape[:-1])
        if start.ndim > 1:
            shape = np.broadcast_shapes(shape, start.shape[:-1])
            T, start = np.broadcast_to(T, (*shape, 4, 4)), np.broadcast_to(start, (*shape, len(self.rest)))
        pieces = cut(T.reshape(-1, 4, 4), start.reshape(-1, len(self.rest)), options, int(solutions))
        done = run(self, pieces, threads, executor, progress)
        q = np.concatenate([each for each, _ in done]) if done else np.empty((0, int(solutions), len(self.rest)))
        numbers = np.concatenate([each for _, each in done]) if done else np.empty((0, lay.NUMBERS))
        return PoseResults(q.reshape(*shape, *q.shape[1:]), self, numbers.reshape(*shape, lay.NUMBERS))

    def singular_values(self, q: Array) -> Array:
        """Of the Jacobian in the wanted rows, (..., nq) → (..., k), descending."""
        J = self.chain.jacobians(q, "local_world_aligned")
        return singular_values(J[..., [ROWS.index(row) for row in self.rows], :])

    def _prepared(self, *given: Any) -> Setup:
        """Options as kernels read them; kept where there is no generator."""
        rng = given[-1]
        if rng is not None:
            if not isinstance(rng, np.random.Generator):
                raise InputError(f"rng must be a numpy Generator or None, got {rng!r}")
            return Setup(self.problem, pack_options(*given[:-1], seed=int(rng.integers(2**53))))
        key = (*given, *map(type, given))  # True is not 1 here
        try:
            return self._setups[key]
        except (KeyError, TypeError):
            made = Setup(self.problem, pack_options(*given[:-1], seed=0))
        if len(self._setups) >= MOST_KEPT:
            self._setups.clear()
        with suppress(TypeError):  # arrays of one number cannot be kept by
            self._setups[key] = made
        return made


class Setup:
    """What a kernel is told about every target alike.

    Attributes:
        options: As kernels read them.
        wanted: How many solutions are compared.
        address: Of the addresses of all that it reads.
    """

    def __init__(self, problem: Array, options: Array) -> None:
        self.options, self.wanted = options, int(options[lay.WANTED])
        self._problem = problem  # kept alive
        self._where = np.array([id(np.ndarray), problem.ctypes.data, options.ctypes.data], dtype=np.int64)
        self.address = int(self._where.ctypes.data)
