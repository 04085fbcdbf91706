"""Inverse kinematics of a robot: configurations whose pose is a target, or is the closest to it."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from functools import cached_property
from typing import Any, Unpack

from numpy.typing import ArrayLike

from robust_ik.checks import Array
from robust_ik.errors import InputError
from robust_ik.kinematics.chain import Chain
from robust_ik.kinematics.twist_rows import checked_rows
from robust_ik.pose_ik import PoseOptions, PoseResult, PoseResults, PoseSolver, wanted_rows
from robust_ik.pose_ik.size import find_size, is_usual, offsets_of, unit_of
from robust_ik.robot.frame_kinematics import FrameKinematics


class PoseInverse(FrameKinematics):
    """A part of `Robot`: where its joints must be for its frames to be somewhere."""

    lower: Array
    upper: Array
    rest: Array

    @cached_property
    def size(self) -> float:
        """What the links from the first axis to the tip span, m; 0 where no joint moves the tip's point.

        Joints that slide count where they are nearest zero; their travel only where links alone are shorter than a
        metre. Of a whole tree, the size of the limb with the longest offsets.
        """
        return find_size(self._longest_chain, self.lower, self.upper)

    @cached_property
    def length_scale(self) -> float:
        """The length that stands for one metre, m per rad, where lengths are compared with angles or with tolerances.

        1 m for robots of 0.2 to 10 m; for others the power of two that is nearest to their `size`, so that a robot
        does the same whatever its lengths are told in.
        """
        return 1.0 if is_usual(self._longest_chain) else unit_of(self.size)

    @cached_property
    def _longest_chain(self) -> Chain:
        if self.tip is not None:
            return self.chain()
        return max(map(self.chain, self.description.leaves), key=lambda chain: float(offsets_of(chain)[1:].sum()))

    @cached_property
    def _pose_solvers(self) -> dict[tuple[str | None, tuple[str, ...]], PoseSolver]:
        return {}

    @cached_property
    def _solve_quickly(self) -> Callable[[Any, Any], PoseResult | None]:
        return self.pose_solver().quickly

    def pose_solver(self, frame: str | None = None, rows: Sequence[str] | None = None) -> PoseSolver:
        """What `solve_pose` asks, for a loop that asks it often; made once for each frame and rows.

        Args:
            frame: Link or joint; default the tip.
            rows: Wanted rows, of x y z wx wy wz; default `self.rows`.
        """
        names = self.rows if rows is None else checked_rows(rows)
        if not isinstance(frame, (str, type(None))):
            raise InputError(f"a frame is named by a str, got {reprlib.repr(frame)}")
        solver = self._pose_solvers.get((frame, names))
        if solver is None:
            solver = PoseSolver(self.chain(frame), self.lower, self.upper, self.rest, names, self.length_scale)
            self._pose_solvers[frame, names] = solver
        return solver

    def solve_pose(
        self,
        target: ArrayLike,
        q0: ArrayLike | None = None,
        *,
        frame: str | None = None,
        rows: Sequence[str] | None = None,
        **options: Unpack[PoseOptions],
    ) -> PoseResult:
        """Inverse kinematics: a configuration inside joint limits whose pose is the target, or is the closest to it.

        Closest is meant in E = ‖Δp‖² + L² ‖Δr‖², in m and rad, over the wanted rows, where L is `length_scale`,
        by default the robot's: 1 m per rad for robots of usual size.

        Args:
            target: A pose (4, 4), or a position (3,), m; then rotations are free.
            q0: Where to begin, (nq,); default `self.rest`. Joints outside their limits are moved inside, and joints
                that do not move the frame stay.
            frame: Link or joint; default the tip.
            rows: Wanted rows, of x y z wx wy wz; default `self.rows`. With two of the rotations, the third world axis
                is one to turn about freely.
            **options: See `PoseOptions`: what is preferred, how many solutions, how much effort, tolerances.

        Returns:
            The configuration, a status (solved, closest, out of reach), the error that is left, the work done.

        Raises:
            InputError: An argument cannot be meant, or more than 16 joints move the frame.
            FrameNotFoundError: There is no such frame.
        """
        if frame is None and rows is None and not options:
            found = self._solve_quickly(target, q0)
            if found is not None:
                return found
        solver = self.pose_solver(frame, wanted_rows(target, rows, self.rows))
        found = None if options else solver.quickly(target, q0)
        return solver.solve(target, q0, **options) if found is None else found

    def solve_poses(
        self,
        targets: ArrayLike,
        q0: ArrayLike | None = None,
        *,
        frame: str | None = None,
        rows: Sequence[str] | None = None,
        threads: int = 1,
        executor: Executor | None = None,
        progress: Callable[[int, int], None] | None = None,
        **options: Unpack[PoseOptions],
    ) -> PoseResults:
        """`solve_pose` for many targets, with the same bits, several times faster than one by one.

        Args:
            targets: Poses (..., 4, 4) or positions (..., 3).
            q0: Where to begin, (..., nq), leading axes broadcast.
            frame: As for `solve_pose`.
            rows: As for `solve_pose`.
            threads: How many to use.
            executor: Where to do it instead: processes, or a cluster.
            progress: Called with how many pieces are done and how many there are.
            **options: As for `solve_pose`.
        """
        solver = self.pose_solver(frame, wanted_rows(targets, rows, self.rows, many=True))
        return solver.solve_many(targets, q0, threads=threads, executor=executor, progress=progress, **options)
