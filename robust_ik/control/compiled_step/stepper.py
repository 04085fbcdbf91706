"""Stepper: a control step in one compiled call."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_out
from robust_ik.checks.public_arguments import check_type
from robust_ik.control.compiled_step.step_program import Program
from robust_ik.control.length_scale import chosen_length_scale, in_units
from robust_ik.errors import InputError
from robust_ik.inverses import DampedLeastSquares, RobustInverse
from robust_ik.kernels.step.step_layout import TOO_LARGE, UNLIKE
from robust_ik.kinematics.twist_rows import checked_rows
from robust_ik.robot.robot import Robot
from robust_ik.robot.robot_kinematics import Reference

SIDE_BY_SIDE = 8
"""Steps that are made side by side: threads get whole multiples of it. As many as lanes, `simd_lanes.COUNT`."""


class Stepper:
    """Joint velocities for a twist in one fast call: kinematics, decomposition and filter are compiled together.

    With DampedLeastSquares it takes half a microsecond, with another filter about two; a filter that is no GainFormula
    takes a few more, since its `gains` is Python. SecondOrder is compiled as well, each step as the first one of a run.
    Any other inverse works too, at the speed of its `solve`. Plain steps
    are compiled in the constructor, those with a secondary velocity and `steps` at their first call, or by `warmup`.

    Attributes:
        robot: The robot.
        inverse: The robust inverse, possibly a `Weighted`.
        length_scale: The unit of lengths, m: 1, or for much larger or smaller robots about their own size.
        compiled: Whether a step is one compiled call.
    """

    def __init__(
        self,
        robot: Robot,
        inverse: RobustInverse | None = None,
        *,
        frame: str | None = None,
        reference: Reference = "local_world_aligned",
        rows: Sequence[str] | None = None,
        length_scale: float | None = None,
    ) -> None:
        """Prepares the step.

        Args:
            robot: Any robot.
            inverse: By default DampedLeastSquares().
            frame: Link or joint that moves; default the tip.
            reference: Of the twist; see `Robot.jacobian`.
            rows: Task rows, of x y z wx wy wz; default the robot's.
            length_scale: L, m per rad: rows in metres, and joints that slide, are divided by it; default as for
                `VelocityController`.

        Raises:
            InputError: The inverse is no RobustInverse, or there is no such reference or row.
            FrameNotFoundError: There is no such frame.
        """
        check_type("robot", robot, "Robot")
        self.robot = robot
        self.inverse = DampedLeastSquares() if inverse is None else inverse
        if not isinstance(self.inverse, RobustInverse):
            raise InputError(f"inverse must be a RobustInverse, got {inverse!r}")
        self.length_scale = chosen_length_scale(robot, (self.inverse,), length_scale)
        chosen = robot.rows if rows is None else checked_rows(rows)
        self._made_of = (frame, reference, chosen, self.length_scale)
        scaled = in_units(self.inverse, robot, chosen, self.length_scale)
        self._program = Program.of(robot.chain(frame), scaled, reference, chosen)
        self._address, self._setup = self._program.address, int(self._program.addresses.ctypes.data)
        self._step = self._program.step if self._program.careful else _unlike
        self._step_beside = self._program.step_beside if self._program.careful else _unlike
        self.compiled = self._program.compiled

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.robot, self.inverse, *self._made_of)

    def __repr__(self) -> str:
        return f"Stepper({self.robot.name!r}, {self.inverse!r}, rows={' '.join(self._made_of[2])})"

    def step(
        self, q: ArrayLike, twist: ArrayLike, out: Array | None = None, secondary: ArrayLike | None = None
    ) -> Array:
        """Joint velocities that give the tip a twist.

        Args:
            q: Configuration, (nq,).
            twist: In the task rows, (m,): m/s and rad/s.
            out: Array for q̇, (n,), contiguous doubles; if q and twist are contiguous doubles too, nothing is
                allocated.
            secondary: Further joint velocities q̇₀ wanted, (n,): their part that does not move the task, (I − V Vᵀ)
                q̇₀, is added; V has all singular directions, for Weighted in its scaled coordinates.

        Returns:
            q̇, (n,), rad/s or m/s: `out` if given.

        Raises:
            InputError: Something has the wrong shape or type, or is NaN or infinite.
        """
        if out is None:
            out = np.empty(self._program.n)
        if secondary is None:
            status = self._step(self._setup, q, twist, out)
        else:
            status = self._step_beside(self._setup, q, twist, secondary, out)
        if status == UNLIKE:
            return self._converted(q, twist, out, secondary)
        if status:
            self._refuse(status, q, twist, secondary)
        return out

    def steps(
        self,
        q: ArrayLike,
        twists: ArrayLike,
        out: Array | None = None,
        secondary: ArrayLike | None = None,
        *,
        threads: int = 1,
    ) -> Array:
        """Many independent steps: if compiled, the same bits as one by one, else the same to rounding.

        Args:
            q: Configurations, (N, nq).
            twists: In the task rows, (N, m).
            out: Array for the result, (N, n), contiguous doubles.
            secondary: As for `step`, (N, n).
            threads: Number of threads; compiled code releases Python's lock.

        Returns:
            q̇, (N, n).

        Raises:
            InputError: As for `step`.
        """
        size = self._program
        unseen = not size.compiled  # compiled code checks itself whether numbers are finite
        q, twists = (
            as_array(each, name, (length,), finite=unseen)
            for each, name, length in ((q, "q", size.nq), (twists, "twists", size.m))
        )
        if q.ndim != 2 or q.shape[:1] != twists.shape[:-1]:
            raise InputError(f"q (N, {size.nq}) and twists (N, {size.m}) are needed, got {q.shape} and {twists.shape}")
        if isinstance(threads, bool) or not isinstance(threads, (int, np.integer)) or threads < 1:
            raise InputError(f"threads must be a whole number of at least 1, got {threads!r}")
        if unseen:
            self.robot.joint_values(q)  # raises if q is no configuration
        beside = np.empty((0, size.n)) if secondary is None else as_array(secondary, "secondary", (size.n,))
        if secondary is not None and beside.shape != (len(q), size.n):
            raise InputError(f"secondary must have shape ({len(q)}, {size.n}), got {beside.shape}")
        out = np.empty((len(q), size.n)) if out is None else checked_out(out, (len(q), size.n))
        overlaps = any(np.may_share_memory(out, each) for each in (q, twists, beside))
        q, twists, beside = ((np.array if overlaps else np.ascontiguousarray)(each) for each in (q, twists, beside))
        share = -(-len(q) // (int(threads) * SIDE_BY_SIDE)) * SIDE_BY_SIDE
        parts = [slice(begin, begin + share) for begin in range(0, len(q), max(share, 1))]

        def some(part: slice) -> int:
            return size.steps(self._address, q[part], twists[part], beside[part], out[part])

        with ThreadPoolExecutor(max(len(parts) - 1, 1)) as pool:  # starts no more threads than needed
            others = pool.map(some, parts[1:])
            found = [some(part) for part in parts[:1]] + list(others)
        if any(found):
            if TOO_LARGE not in found:
                as_array(twists, "twists", (size.m,))
            self._refuse(max(found), q, twists, None if secondary is None else beside)
        return out

    def _converted(self, q: ArrayLike, twist: ArrayLike, out: Array, secondary: ArrayLike | None) -> Array:
        """A step from arguments that are not contiguous doubles."""
        size = self._program
        self.robot.joint_values(q)
        given = [as_array(q, "q", (size.nq,)), as_array(twist, "twist", (size.m,))]
        if secondary is not None:
            given.append(as_array(secondary, "secondary", (size.n,)))
        for name, array in zip(("q", "twist", "secondary"), given):
            if array.ndim != 1:
                raise InputError(f"step takes one {name}, got shape {array.shape}; steps takes many")
        checked_out(out, (size.n,))
        given = [np.array(each, dtype=float) for each in given]
        make = size.step if secondary is None else size.step_beside
        status = make(self._setup, *given, out.view(np.ndarray))
        if status:
            self._refuse(status, given[0], given[1], secondary)
        return out

    def _refuse(self, status: int, q: ArrayLike, twist: ArrayLike, secondary: ArrayLike | None) -> NoReturn:
        """Raises the error for a step that was not made."""
        if status != TOO_LARGE:  # otherwise these may have been overwritten
            self.robot.joint_values(q)
            as_array(twist, "twist", (self._program.m,))
        elif secondary is not None:
            as_array(secondary, "secondary", (self._program.n,))
        raise InputError(NO_NUMBERS)


NO_NUMBERS = "the joint velocities are too large to be numbers; out has no meaning"


def _unlike(*_: Any) -> int:
    """Returns UNLIKE for all arguments, so that they are converted first."""
    return UNLIKE


def _again(
    robot: Robot,
    inverse: RobustInverse,
    frame: str | None,
    reference: Reference,
    rows: Sequence[str],
    length_scale: float,
) -> Stepper:
    return Stepper(robot, inverse, frame=frame, reference=reference, rows=rows, length_scale=length_scale)
