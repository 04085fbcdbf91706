"""PoseSolver: inverse kinematics of one frame in some rows, prepared once, for single and many targets. Arrays only."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, check_leading_axes
from robust_ik.errors import InputError
from robust_ik.kernels.pose import pose_layout as lay
from robust_ik.kinematics.chain import Chain
from robust_ik.kinematics.svd import singular_values
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.pose_ik.free_slides import FreeSlides
from robust_ik.pose_ik.inputs import (
    POSITIONS,
    as_pose,
    as_poses,
    as_start,
    as_starts,
    is_near,
    plain,
    quick_pose,
    refuse,
)
from robust_ik.pose_ik.options import Effort, Prefer, pack_options
from robust_ik.pose_ik.packing import pack
from robust_ik.pose_ik.result import PoseResult, PoseResults, SeveralSolutions
from robust_ik.pose_ik.scaled_problem import PoseUnits
from robust_ik.runtime.parallel import run_pieces

ROTATION_TOLERANCE, APART = 1e-8, 0.1
"""Default tolerances, rad.

Chosen: 1e-8 is far above rounding; solutions of two branches usually differ by more than 0.1.
"""
USUAL = ("nearest", 1, "normal", None, ROTATION_TOLERANCE, None, APART)
MOST_KEPT = 64
"""Most sets of options that a solver keeps packed for kernels."""

PIECE = 1024
"""Targets in a piece: the same for any number of workers."""


@dataclass(frozen=True, eq=False)
class PoseSolver:
    """Inverse kinematics of one frame, in some rows, within joint limits; `Robot.pose_solver` makes it.

    Damped least squares with an active set of limits starts from q0, then from a table of configurations with near
    poses, then from random ones; a start is given up as soon as it falls behind. If no start reaches the target, the
    best ones are polished by Newton's method. The same input gives the same bits, one by one, in batches and on
    threads.

    Attributes:
        chain: The joints that move the frame.
        lower: Limits of the n joints, rad or m.
        upper: The same.
        rest: Where a search begins without a q0, (nq,).
        rows: Wanted rows, of x y z wx wy wz.
        unit: The length that stands for one metre, m; see `Robot.length_scale`.
    """

    chain: Chain
    lower: Array
    upper: Array
    rest: Array
    rows: tuple[str, ...]
    unit: float = 1.0

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.chain, self.lower, self.upper, self.rest, self.rows, self.unit)

    @cached_property
    def problem(self) -> Array:
        """The packed problem for kernels, with the table of starts."""
        if self.units is None:
            return pack(self.chain, self.lower, self.upper, self.rows)
        joints = self.units.joints
        return pack(self.units.chain(self.chain), self.lower / joints, self.upper / joints, self.rows)

    @cached_property
    def units(self) -> PoseUnits | None:
        """The units of lengths in kernels; None for metres."""
        return None if self.unit == 1.0 else PoseUnits.of(self.chain, self.unit)

    @cached_property
    def slides(self) -> FreeSlides | None:
        """The slides without limits that the chain begins with; None if there are none."""
        return FreeSlides.of(self.chain, self.lower, self.upper, self.unit)

    @cached_property
    def _setups(self) -> dict[Any, Setup]:
        return {}

    @cached_property
    def _kernel(self) -> Callable[..., Any]:
        from robust_ik.kernels.pose import solve_one

        return solve_one.compiled

    @cached_property
    def quickly(self) -> Callable[[Any, Any], PoseResult | None]:
        """`solve` with default options, half a microsecond faster.

        It returns None, so that `solve` has to be called, unless arguments are arrays or lists of numbers that are
        valid, lengths are in metres, and no slide without limits is in front.
        """
        if self.units is not None or self.slides is not None:
            return lambda target, q0: None  # noqa: ARG005
        setup = Setup(self.problem, pack_options(*USUAL, seed=0))
        kernel, rest, nq, empty = self._kernel, self.rest, len(self.rest), np.empty
        position = set(self.rows) <= set(POSITIONS)

        def solve(target: Any, q0: Any) -> PoseResult | None:
            q, numbers = empty(nq), empty(lay.NUMBERS)
            start = rest if q0 is None else q0
            if kernel(setup.address, target, start, q, numbers):
                return PoseResult(q, numbers, self)
            T = quick_pose(target, position)
            if T is not None and kernel(
                setup.address, T, np.array(start) if type(start) is list else start, q, numbers
            ):
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
        position_tolerance: float | None = None,
        rotation_tolerance: float = ROTATION_TOLERANCE,
        length_scale: float | None = None,
        apart: float = APART,
        rng: np.random.Generator | None = None,
    ) -> PoseResult:
        """A configuration that reaches the target, or the closest; see `Robot.solve_pose`."""
        given = (prefer, solutions, effort, position_tolerance, rotation_tolerance, length_scale, apart)
        if rng is None and all(each is usual for each, usual in zip(given, USUAL)):
            found = self.quickly(target, q0)
            if found is not None:
                return found
        setup = self._prepared(*given, rng)
        T, start = as_pose(target), self.rest if q0 is None else as_start(q0, self.rest)
        q, numbers = np.empty((setup.wanted, len(self.rest))), np.empty(lay.NUMBERS)
        if not self._ask(setup, T, start, q, numbers):
            # Arrays of another type or layout, or arguments that are not valid.
            T, start = as_pose(plain(target, "target")), as_start(plain(start, "q0"), self.rest)
            if not self._ask(setup, T, start, q, numbers):
                refuse(T, start, self.rest, self.unit)
        if setup.wanted == 1:
            return PoseResult(q[0], numbers, self)
        return SeveralSolutions(q[: min(max(int(numbers[lay.FOUND]), 1), int(solutions))], numbers, self)

    def _ask(self, setup: Setup, T: Array, start: Array, q: Array, numbers: Array) -> bool:
        """Calls the kernel for one target; False if it refuses target or start."""
        travel = None
        if self.slides is not None:
            if not (is_near(T[:3, 3], self.unit) and is_near(start)):
                return False
            travel = self.slides.travel(T)
            T, start = self.slides.near(T, travel), self.slides.moved(start, -travel)
        if self.units is not None:
            T, start = self.units.targets(T), start / self.units.q
        taken = bool(self._kernel(setup.address, T, start, q, numbers))
        if taken and self.units is not None:
            self.units.restore(q, numbers)
        if taken and self.slides is not None and travel is not None:
            q[:] = self.slides.moved(q, travel)
        return taken

    def solve_many(
        self,
        targets: ArrayLike,
        q0: ArrayLike | None = None,
        *,
        prefer: Prefer = "nearest",
        solutions: int = 1,
        effort: Effort = "normal",
        position_tolerance: float | None = None,
        rotation_tolerance: float = ROTATION_TOLERANCE,
        length_scale: float | None = None,
        apart: float = APART,
        rng: np.random.Generator | None = None,
        threads: int = 1,
        executor: Executor | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> PoseResults:
        """Configurations that reach the targets, or the closest ones; see `Robot.solve_poses`."""
        options = self._prepared(
            prefer, solutions, effort, position_tolerance, rotation_tolerance, length_scale, apart, rng
        ).options
        T, start = as_poses(targets, self.unit), as_starts(self.rest if q0 is None else q0, self.rest)
        shape = T.shape[:-2]
        check_leading_axes("targets", shape, "q0", start.shape[:-1])
        if start.ndim > 1:
            shape = np.broadcast_shapes(shape, start.shape[:-1])
            T, start = np.broadcast_to(T, (*shape, 4, 4)), np.broadcast_to(start, (*shape, len(self.rest)))
        travel = None
        if self.slides is not None:
            travel, start = self.slides.travel(T), np.broadcast_to(start, (*shape, len(self.rest)))
            T, start = self.slides.near(T, travel), self.slides.moved(start, -travel)
        if self.units is not None:
            T, start = self.units.targets(T), start / self.units.q
        pieces = cut(T.reshape(-1, 4, 4), start.reshape(-1, len(self.rest)), options, int(solutions))
        done = run(self, pieces, threads, executor, progress)
        q = np.concatenate([each for each, _ in done]) if done else np.empty((0, int(solutions), len(self.rest)))
        numbers = np.concatenate([each for _, each in done]) if done else np.empty((0, lay.NUMBERS))
        if self.units is not None:
            self.units.restore(q, numbers)
        if self.slides is not None and travel is not None:
            q = self.slides.moved(q, travel.reshape(-1, 1, travel.shape[-1]))
        return PoseResults(q.reshape(*shape, *q.shape[1:]), self, numbers.reshape(*shape, lay.NUMBERS))

    def singular_values(self, q: Array) -> Array:
        """Singular values of the Jacobian in the wanted rows, (..., nq) → (..., k), descending."""
        q = as_array(q, "q", (self.chain.nq,))
        J = self.chain.jacobians(q, "local_world_aligned")
        return singular_values(J[..., [ROWS.index(row) for row in self.rows], :])

    def _prepared(self, *given: Any) -> Setup:
        """The options packed for kernels; kept for the next call unless there is a generator."""
        rng = given[-1]
        if rng is not None:
            if not isinstance(rng, np.random.Generator):
                raise InputError(f"rng must be a numpy Generator or None, got {rng!r}")
            return Setup(self.problem, self._packed(given, int(rng.integers(2**53))))
        key = (*given, *map(type, given))  # with types, since True == 1
        try:
            return self._setups[key]
        except (KeyError, TypeError):
            made = Setup(self.problem, self._packed(given, 0))
        if len(self._setups) >= MOST_KEPT:
            self._setups.clear()
        with suppress(TypeError):  # an array is no key of a dictionary
            self._setups[key] = made
        return made

    def _packed(self, given: tuple[Any, ...], seed: int) -> Array:
        return pack_options(*given[:-1], seed=seed, unit=self.unit)


class Setup:
    """What a kernel needs besides the target: the problem and the options.

    Attributes:
        options: The packed options.
        wanted: How many solutions are compared.
        address: Address of the array that holds the addresses of NumPy's array class, problem and options.
    """

    def __init__(self, problem: Array, options: Array) -> None:
        self.options, self.wanted = options, int(options[lay.WANTED])
        self._problem = problem  # kept alive
        self._where = np.array([id(np.ndarray), problem.ctypes.data, options.ctypes.data], dtype=np.int64)
        self.address = int(self._where.ctypes.data)


Done = tuple[Array, Array]


class Piece(NamedTuple):
    """Targets that are solved together, with their options."""

    targets: Array
    q0: Array
    options: Array
    solutions: int


def cut(targets: Array, q0: Array, options: Array, solutions: int) -> list[Piece]:
    """Splits targets (N, 4, 4) with q0 (N, nq) or (1, nq) into pieces."""
    return [
        Piece(targets[i : i + PIECE], q0 if len(q0) == 1 else q0[i : i + PIECE], options, solutions)
        for i in range(0, len(targets), PIECE)
    ]


def solve_piece(solver: PoseSolver, piece: Piece) -> Done:
    """Solutions (N, s, nq) and numbers of one piece."""
    from robust_ik.kernels.pose import solve_many

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
        InputError: `threads` is not a whole number of at least 1.
    """
    if isinstance(threads, bool) or not isinstance(threads, (int, np.integer)) or threads < 1:
        raise InputError(f"threads must be a whole number of at least 1, got {threads!r}")
    work = partial(solve_piece, solver)
    if executor is not None or threads == 1 or len(pieces) < 2:
        return run_pieces(work, pieces, executor, progress)
    solver.problem  # noqa: B018 - made once, before threads ask for it
    with ThreadPoolExecutor(int(threads)) as pool:
        return run_pieces(work, pieces, pool, progress)
