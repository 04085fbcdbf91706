"""PoseSolver: inverse kinematics of one frame in some rows, prepared once. Arrays only."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, field
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
from robust_ik.pose_ik.result import PoseResult, PoseResults
from robust_ik.rows import ROWS

POSITION_TOLERANCE, ROTATION_TOLERANCE = 1e-8, 1e-8

LENGTH_SCALE, APART = 1.0, 0.1
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
    _options: dict[Any, tuple[Array, int]] = field(default_factory=dict, repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.chain, self.lower, self.upper, self.rest, self.rows)

    @cached_property
    def problem(self) -> Array:
        """What kernels read, with the table of starts."""
        return pack(self.chain, self.lower, self.upper, self.rows)

    @cached_property
    def _usual_address(self) -> int:
        return int(self._usual[0].ctypes.data)

    @cached_property
    def _usual(self) -> tuple[Array, int]:
        return prepared(("nearest", 1, "normal", POSITION_TOLERANCE, ROTATION_TOLERANCE, LENGTH_SCALE, APART), 0)

    @cached_property
    def _address(self) -> int:
        return int(self.problem.ctypes.data)

    @cached_property
    def _kernel(self) -> Callable[..., Any]:
        from robust_ik.kernels.pose_search import solve_one  # imports Numba, half a second: only where it is needed

        return solve_one.compiled

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
        packed, wanted = self._prepared(
            prefer, solutions, effort, position_tolerance, rotation_tolerance, length_scale, apart, rng
        )
        found = self._solve(int(packed.ctypes.data), wanted, target, q0)
        if wanted == 1:
            return found
        count = min(max(int(found._numbers.item(lay.FOUND)), 1), int(solutions))
        return PoseResult(found.solutions[:count], self, found._numbers)

    def solve_usual(self, target: ArrayLike, q0: ArrayLike | None = None) -> PoseResult:
        """`solve` where nothing is said of options, half a microsecond faster."""
        return self._solve(self._usual_address, 1, target, q0)

    def _solve(self, options: int, wanted: int, target: ArrayLike, q0: ArrayLike | None) -> PoseResult:
        """With packed options by their address."""
        rest = self.rest
        T = target if type(target) is np.ndarray and target.shape == (4, 4) else as_pose(target)
        start = rest if q0 is None else as_start(q0, rest)
        q, numbers = np.empty((wanted, len(rest))), np.empty(lay.NUMBERS)
        try:
            meant = self._kernel(self._address, options, T, start, q, numbers)
        except TypeError:  # another type of number or layout
            T, start = as_pose(plain(target, "target")), as_start(plain(start, "q0"), rest)
            meant = self._kernel(self._address, options, T, start, q, numbers)
        if not meant:
            refuse(T, start, rest)
        return PoseResult(q, self, numbers)

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
        packed, _ = self._prepared(
            prefer, solutions, effort, position_tolerance, rotation_tolerance, length_scale, apart, rng
        )
        T, start = as_poses(targets), as_starts(self.rest if q0 is None else q0, self.rest)
        shape = T.shape[:-2]
        check_leading_axes("targets", shape, "q0", start.shape[:-1])
        if start.ndim > 1:
            shape = np.broadcast_shapes(shape, start.shape[:-1])
            T, start = np.broadcast_to(T, (*shape, 4, 4)), np.broadcast_to(start, (*shape, len(self.rest)))
        pieces = cut(T.reshape(-1, 4, 4), start.reshape(-1, len(self.rest)), packed, int(solutions))
        done = run(self, pieces, threads, executor, progress)
        q = np.concatenate([each for each, _ in done]) if done else np.empty((0, int(solutions), len(self.rest)))
        numbers = np.concatenate([each for _, each in done]) if done else np.empty((0, lay.NUMBERS))
        return PoseResults(q.reshape(*shape, *q.shape[1:]), self, numbers.reshape(*shape, lay.NUMBERS))

    def singular_values(self, q: Array) -> Array:
        """Of the Jacobian in the wanted rows, (..., nq) → (..., k), descending."""
        J = self.chain.jacobians(q, "local_world_aligned")
        return singular_values(J[..., [ROWS.index(row) for row in self.rows], :])

    def _prepared(self, *given: Any) -> tuple[Array, int]:
        """Options as kernels read them and how many solutions are compared; kept where there is no generator."""
        rng = given[-1]
        if rng is not None:
            if not isinstance(rng, np.random.Generator):
                raise InputError(f"rng must be a numpy Generator or None, got {rng!r}")
            return prepared(given[:-1], int(rng.integers(2**53)))
        key = (*given, *map(type, given))  # True is not 1 here
        try:
            return self._options[key]
        except (KeyError, TypeError):
            made = prepared(given[:-1], 0)
        if len(self._options) >= MOST_KEPT:
            self._options.clear()
        with suppress(TypeError):  # arrays of one number cannot be kept by
            self._options[key] = made
        return made


def prepared(options: tuple[Any, ...], seed: int) -> tuple[Array, int]:
    """Options as kernels read them, and how many solutions are compared."""
    packed = pack_options(*options, seed=seed)
    return packed, int(packed[lay.WANTED])
