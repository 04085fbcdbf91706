"""BranchSolver: all solutions of the poses of one frame in some rows, prepared once. Arrays only."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robust_ik.branches.dual_quaternions import ONE, line, moved
from robust_ik.branches.held_joints import HeldJoints
from robust_ik.branches.loop_plans import Loop, choose_plans
from robust_ik.branches.result import AllSolutions, ManySolutions, SelfMotion, SolutionsStatus
from robust_ik.branches.screw_axes import ScrewAxes
from robust_ik.branches.self_motion import ClosedLoop, Traced, trace, within_limits
from robust_ik.checks import Array
from robust_ik.errors import InputError
from robust_ik.kernels.branches import branches_layout as lay
from robust_ik.kinematics.chain import Chain
from robust_ik.kinematics.twist_rows import ROWS

SINGULAR = 1e-6
"""Least pivot of a Jacobian over its largest one up to which a solution is called singular."""
ON_THE_CURVE = 1e-3
"""Distance from a traced curve up to which a solution belongs to it, rad and units of length."""
STATUS = {
    lay.EVERY: SolutionsStatus.EVERY,
    lay.NEARBY: SolutionsStatus.DEGENERATE,
    lay.DOUBTFUL: SolutionsStatus.DOUBTFUL,
    lay.DEGENERATE: SolutionsStatus.DOUBTFUL,
}
MOST_TURNED = 100_000
"""Most solutions with turns. Chosen: eight of a UR have 512; what nobody looks through shall not fill the memory."""
AT_LIMIT = 1e-9
"""By how much a joint may pass its limit, rad."""
SAME = 1e-5
"""Solutions of a search that differ by less from one that is known are that one, rad and units of length."""
HELD = 2
"""How many joints of a redundant arm are held in turn."""
PARALLEL = 1e-9
"""Sine of the angle between an axis and a row up to which a joint turns in that row alone."""


@dataclass(frozen=True, eq=False)
class BranchSolver:
    """All solutions of the poses of one frame, in some rows; `Robot.branch_solver` makes it.

    Attributes:
        chain: The joints that move the frame.
        lower: Limits of the n joints, rad or m.
        upper: The same.
        rows: Wanted rows, of x y z wx wy wz.
        names: Names of the n joints.
        to_q: Joint values (..., n) → q (..., nq).
        search: Solutions found from many starts, for a pose (4, 4) and joint values (n,): joint values (s, n).
    """

    chain: Chain
    lower: Array
    upper: Array
    rows: tuple[str, ...]
    names: tuple[str, ...]
    to_q: Callable[[Array], Array]
    search: Callable[[Array, Array], Array]

    @cached_property
    def arm(self) -> ScrewAxes | None:
        """The arm's joints; None if the loop has no form of its own, e.g. where a joint follows another one."""
        arm = ScrewAxes.of(self.chain)
        if arm is None or (self._single and not self._turns_in_one_row(arm)):
            return None
        return arm

    @cached_property
    def loop(self) -> Loop | None:
        """The closed loop of six joints; None if there is none."""
        return None if self.arm is None else Loop.of(self.arm, self.rows)

    @cached_property
    def units(self) -> Array:
        """Rad or m per unit of each joint of the arm, (c,)."""
        assert self.arm is not None
        return self.arm.units

    @cached_property
    def _packed(self) -> Array:
        assert self.arm is not None
        return self.arm.packed(self.chain.n)

    @cached_property
    def quickly(self) -> Callable[[Any, Any], AllSolutions | None]:
        """`solve` of a pose that every root is accounted for, without checks.

        It returns None, so that `solve` has to be called, unless the pose is an array (4, 4) of doubles that is rigid,
        the joint values an array of doubles, and the pose not degenerate.
        """
        if not len(self.plans) or self._single:
            return lambda target, near: None  # noqa: ARG005
        from robust_ik.kernels.branches import branches

        kernel, plans, packed, method, n = branches.compiled, self.plans, self._packed, self.method, self.chain.n
        empty, to_q = np.empty, self.to_q

        def solve(target: Any, near: Any) -> AllSolutions | None:
            values, found = empty((1, lay.SOLUTIONS, n)), empty((1, lay.SOLUTIONS, lay.ROW))
            numbers = empty((1, lay.NUMBERS))
            if not kernel(plans, packed, target[None], near[None], values, found, numbers):
                return None
            count, verdict, _, allowed = numbers[0, : lay.WORK].tolist()
            count, allowed = int(count), int(allowed)
            weakest = found[0, :count, lay.SIGMA]
            if verdict != lay.EVERY or (count and weakest.min() < SINGULAR):
                return None
            q = to_q(values[0, :count])
            return AllSolutions(
                q[:allowed], q[allowed:], SolutionsStatus.EVERY, weakest[:allowed] < SINGULAR, (), method
            )

        return solve

    @cached_property
    def plans(self) -> Array:
        """The plans of the loop, (k, SIZE); k = 0 where no plan finds what is there."""
        if self.arm is None or self.loop is None:
            return np.zeros((0, lay.SIZE))
        return choose_plans(
            self.loop, self.lower[self.arm.columns] / self.units, self.upper[self.arm.columns] / self.units
        )

    @property
    def is_redundant(self) -> bool:
        """Whether the arm has more joints than its rows need, so that solutions are curves."""
        return self.arm is not None and self.loop is None

    @cached_property
    def held(self) -> HeldJoints | None:
        """How self-motions are found, of an arm with a joint too many or at degenerate poses; None if they are not."""
        if self.arm is None:
            return None
        columns = self.arm.columns
        count = HELD if self.is_redundant else len(columns)
        return HeldJoints.of(self.arm, self.rows, self.lower[columns], self.upper[columns], count)

    @property
    def method(self) -> str:
        """How solutions are found, in words."""
        if len(self.plans):
            return "closed form" if self.plans[0, lay.TRIPLE] else "elimination"
        return "self-motions" if self.is_redundant and self.held is not None else "search"

    @property
    def _single(self) -> bool:
        return sum(row.startswith("w") for row in self.rows) == 1

    def _turns_in_one_row(self, arm: ScrewAxes) -> bool:
        (row,) = (row for row in self.rows if row.startswith("w"))
        axis = np.eye(3)[ROWS.index(row) - 3]
        turning = arm.axes[~arm.slides, 1:4]
        return bool((np.linalg.norm(np.cross(turning, axis), axis=1) < PARALLEL).all())

    def targets(self, T: Array) -> Array:
        """The targets, turned to what the arm can reach if one rotation alone is wanted, (..., 4, 4).

        The rest of the rotation is free then: R becomes the turn about the wanted row next to it.
        """
        if not self._single or self.arm is None:
            return T
        (row,) = (row for row in self.rows if row.startswith("w"))
        axis = ROWS.index(row) - 3
        home = self.arm.home[:3, :3]
        R = T[..., :3, :3] @ home.T
        i, j = (axis + 1) % 3, (axis + 2) % 3
        # The twist about the axis: the quaternion's part along it and its real part.
        angle = np.arctan2(R[..., j, i] - R[..., i, j], R[..., i, i] + R[..., j, j])
        turned = np.zeros_like(R)
        turned[..., axis, axis] = 1.0
        turned[..., i, i] = turned[..., j, j] = np.cos(angle)
        turned[..., j, i], turned[..., i, j] = np.sin(angle), -np.sin(angle)
        made = np.array(T)
        made[..., :3, :3] = turned @ home
        return made

    def solve(self, target: Array, near: Array) -> AllSolutions:
        """All solutions of a pose (4, 4); see `Robot.all_solutions`.

        Args:
            target: The pose, checked.
            near: Joint values, (n,), that solutions are sorted by; joints that do not move the frame keep them.
        """
        if len(self.plans):
            return self._by_elimination(target, near)
        if self.method == "self-motions":
            return self._by_self_motions(target, near)
        values = self.search(target, near)
        return AllSolutions(
            self.to_q(values),
            self.to_q(values[:0]),
            SolutionsStatus.SEARCHED,
            np.zeros(len(values), dtype=bool),
            (),
            self.method,
        )

    def with_turns(self, found: AllSolutions, values: Array) -> AllSolutions:
        """The solutions with every full turn of joints that stays within finite limits.

        Args:
            found: Solutions.
            values: Their joint values, (s, n).

        Raises:
            InputError: There are more than MOST_TURNED.
        """
        turning = self.turning
        made: list[Array] = []
        kept: list[bool] = []
        for q, singular in zip(values, found.singular):
            low = np.where(turning, np.ceil((self.lower - AT_LIMIT - q) / (2 * np.pi)), 0)
            high = np.where(turning, np.floor((self.upper + AT_LIMIT - q) / (2 * np.pi)), 0)
            count = math.prod(int(each) for each in high - low + 1)
            if len(made) + count > MOST_TURNED:
                raise InputError(f"with turns there are more than {MOST_TURNED} solutions; give narrower limits")
            turns = np.array(list(itertools.product(*(np.arange(a, b + 1) for a, b in zip(low, high)))))
            order = np.argsort(np.abs(turns).sum(axis=1), kind="stable")
            made += list(q + 2 * np.pi * turns[order])
            kept += [bool(singular)] * count
        every = np.array(made).reshape(-1, values.shape[-1])
        return replace(found, q=self.to_q(np.clip(every, self.lower, self.upper)), singular=np.array(kept, dtype=bool))

    @cached_property
    def turning(self) -> NDArray[np.bool_]:
        """Joints that may turn by 2π within finite limits without moving the frame, (n,)."""
        finite = np.isfinite(self.lower) & np.isfinite(self.upper)
        turns = np.zeros(len(self.lower), dtype=bool)
        if self.arm is not None:
            turns[self.arm.columns[~self.arm.slides]] = True
        return turns & finite

    def solve_many(self, targets: Array, near: Array) -> ManySolutions:
        """All solutions of poses (..., 4, 4), near joint values (..., n) or (n,); see `Robot.all_solutions_many`."""
        shape, n = targets.shape[:-2], near.shape[-1]
        flat = targets.reshape(-1, 4, 4)
        starts = near[None] if near.ndim == 1 else np.broadcast_to(near, (*shape, n)).reshape(-1, n)
        if len(self.plans):
            values, found, numbers = self._ask(flat, starts)
            allowed = numbers[:, lay.ALLOWED].astype(int)
            most = max(int(allowed.max(initial=0)), 1)
            missing = np.arange(most) >= allowed[:, None]
            q = np.where(missing[..., None], np.nan, self.to_q(np.where(missing[..., None], 0.0, values[:, :most])))
            weak, count = found[:, :most, lay.SIGMA] < SINGULAR, numbers[:, lay.COUNT].astype(int)
            return ManySolutions(
                q.reshape(*shape, *q.shape[1:]),
                allowed.reshape(shape),
                (count - allowed).reshape(shape),
                (numbers[:, lay.VERDICT] == lay.EVERY).reshape(shape),
                (weak & ~missing).reshape(*shape, most),
            )
        each = [self.solve(T, start) for T, start in zip(flat, np.broadcast_to(starts, (len(flat), n)))]
        most = max([len(one) for one in each] + [1])
        q = np.full((len(each), most, self.to_q(starts[:1]).shape[-1]), np.nan)
        singular = np.zeros((len(each), most), dtype=bool)
        for row, one in enumerate(each):
            q[row, : len(one)], singular[row, : len(one)] = one.q, one.singular
        counts = np.array([[len(one), len(one.beyond), one.complete] for one in each], dtype=int).reshape(-1, 3)
        return ManySolutions(
            q.reshape(*shape, *q.shape[1:]),
            counts[:, 0].reshape(shape),
            counts[:, 1].reshape(shape),
            (counts[:, 2] > 0).reshape(shape),
            singular.reshape(*shape, most),
        )

    def _ask(self, targets: Array, near: Array) -> tuple[Array, Array, Array]:
        """Calls the kernel for poses (N, 4, 4): joint values, rows and numbers."""
        from robust_ik.kernels.branches import branches

        count, n = len(targets), self.chain.n
        values, found = np.zeros((count, lay.SOLUTIONS, n)), np.zeros((count, lay.SOLUTIONS, lay.ROW))
        numbers = np.zeros((count, lay.NUMBERS))
        poses, close = np.ascontiguousarray(self.targets(targets)), np.ascontiguousarray(near)
        branches.compiled(self.plans, self._packed, poses, close, values, found, numbers)
        return values, found, numbers

    def _by_elimination(self, target: Array, near: Array) -> AllSolutions:
        values, found, numbers = self._ask(target[None], near[None])
        count, allowed, verdict = (int(numbers[0, k]) for k in (lay.COUNT, lay.ALLOWED, lay.VERDICT))
        assert self.arm is not None
        rows: Array = found[0, :count]
        curves: list[SelfMotion] = []
        joints = values[0, :count]
        if verdict != lay.EVERY or (rows[:, lay.SIGMA] < SINGULAR).any():
            rows, allowed, curves = self._with_curves(target, rows, near, degenerate=verdict != lay.EVERY)
            joints = np.repeat(near[None], len(rows), axis=0)
            joints[:, self.arm.columns] = rows[:, : len(self.units)] * self.units
        q = self.to_q(joints)
        singular = rows[:allowed, lay.SIGMA] < SINGULAR
        return AllSolutions(q[:allowed], q[allowed:], STATUS[float(verdict)], singular, tuple(curves), self.method)

    def _with_curves(
        self, target: Array, rows: Array, near: Array, *, degenerate: bool
    ) -> tuple[Array, int, list[SelfMotion]]:  # fmt: skip
        """The rows with one of each self-motion, how many are within limits, and the self-motions within limits."""
        assert self.arm is not None
        loop, own = self._closed_loop(target), len(self.units)
        close = near[self.arm.columns] / self.units
        inside: list[Array] = []
        beyond: list[Array] = []
        known: list[Traced] = []
        pieces: list[Traced] = []
        if degenerate and self.held is not None:
            pieces = self.held.curves(loop)
            sample = np.zeros(lay.ROW)
            inside = [_with_joints(sample, piece.nearest(loop, close)) for piece in pieces]
            whole = [trace(loop.free, piece.values[len(piece.values) // 2]) for piece in pieces]
            known = [each for each in whole if isinstance(each, Traced)]
        for row in rows:
            if row[lay.SIGMA] < SINGULAR:
                if any(curve.holds(loop, row[:own]) for curve in known):
                    continue
                traced = trace(loop.free, self._joints(row, loop))
                if isinstance(traced, Traced):
                    known.append(traced)
                    found = within_limits(loop, traced, close)
                    pieces += found
                    inside += [_with_joints(row, piece.nearest(loop, close)) for piece in found]
                    beyond += [row] if not found else []
                    continue
            (inside if row[lay.INSIDE] > 0 else beyond).append(row)
        if degenerate:
            inside += self._searched(target, near, [*inside, *beyond], [*known, *pieces], loop)
        inside.sort(key=lambda row: float(np.linalg.norm(row[:own] - close)))
        made = np.array([*inside, *beyond]).reshape(-1, lay.ROW)
        return made, len(inside), [self.curve(one, near) for one in pieces]

    def _searched(
        self, target: Array, near: Array, kept: list[Array], curves: list[Traced], loop: ClosedLoop
    ) -> list[Array]:
        """Rows of solutions that a search from many starts finds beside those kept and on curves."""
        assert self.arm is not None
        own = len(self.units)
        made: list[Array] = []
        for values in self.search(target, near)[:, self.arm.columns] / self.units:
            known = [*kept, *made]
            far = [np.abs(loop.difference(row[:own], values)).max() for row in known]
            if min(far, default=np.inf) > SAME and not any(curve.holds(loop, values) for curve in curves):
                made.append(_with_joints(np.ones(lay.ROW), values))
        return made

    def _joints(self, row: Array, loop: ClosedLoop) -> Array:
        """Joint values of a closed loop: without those that are locked, and without free rotations."""
        assert self.loop is not None
        own, first = self.loop.own, 6 - self.loop.floating
        return np.asarray(np.concatenate([row[:own], row[first : first + len(loop.axes) - own]]))

    def _closed_loop(self, target: Array) -> ClosedLoop:
        """The loop of the arm's joints and those that float."""
        arm = self.arm
        assert arm is not None
        (g,) = arm.motors(self.targets(target)[None])
        axes = floating_axes(arm, self.rows, g)
        slides = np.concatenate([arm.slides, [not axis[1:4].any() for axis in axes]]).astype(bool)
        low, high = self.lower[arm.columns] / self.units, self.upper[arm.columns] / self.units
        rotates = any(row.startswith("w") for row in self.rows)
        return ClosedLoop(np.array([*arm.axes, *axes]), slides, g, arm.point, rotates, low, high)

    def curve(self, traced: Traced, near: Array) -> SelfMotion:
        """A traced curve in the robot's configurations."""
        assert self.arm is not None
        columns = self.arm.columns
        values = np.repeat(near[None], len(traced.values), axis=0)
        values[:, columns] = traced.values[:, : len(columns)] * self.units
        moving = np.ptp(values[:, columns] / self.units, axis=0) > 1e-6
        q = self.to_q(values)
        J = self.chain.jacobians(q, "local_world_aligned")[..., [ROWS.index(row) for row in self.rows], :]
        s = np.linalg.svd(J, compute_uv=False)
        rank = int((s[:, :] > 1e-6 * s[:, :1]).sum(axis=1).max())
        names = tuple(self.names[column] for column, moves in zip(columns, moving) if moves)
        return SelfMotion(q, traced.closed, names, np.asarray(s[:, rank - 1]))

    def _by_self_motions(self, target: Array, near: Array) -> AllSolutions:
        assert self.held is not None
        assert self.arm is not None
        loop = self._closed_loop(target)
        traced = self.held.curves(loop)
        curves = tuple(self.curve(one, near) for one in traced)
        best = []
        for one in traced:
            best.append(one.nearest(loop, near[self.arm.columns] / self.units) * self.units)
        values = np.repeat(near[None], len(best), axis=0)
        if best:
            values[:, self.arm.columns] = best
        order = np.argsort(np.linalg.norm(values - near, axis=1), kind="stable")
        q = self.to_q(values[order])
        return AllSolutions(
            q, q[:0], SolutionsStatus.CURVES, np.zeros(len(q), dtype=bool), tuple(curves[i] for i in order), self.method
        )


def _with_joints(row: Array, values: Array) -> Array:
    """The row with other joint values, within limits."""
    made = row.copy()
    made[: len(values)], made[lay.INSIDE] = values, 1.0
    return made


def floating_axes(arm: ScrewAxes, rows: Sequence[str], g: Array) -> list[Array]:
    """Axes of the rows that are free, through the tool's point, turned back by g; none for three free rotations."""
    free = [row for row in ROWS if row not in rows]
    spinning = [row for row in free if row.startswith("w")]
    back = ONE * 0
    back[:4] = g[:4] * np.array([1, -1, -1, -1])
    made = []
    for row in free:
        direction = moved(back, line(np.eye(3)[ROWS.index(row) % 3], np.zeros(3)))[1:4]
        if not row.startswith("w"):
            made.append(np.concatenate([np.zeros(5), direction]))
        elif len(spinning) == 1:
            made.append(line(direction, arm.point))
    return made
