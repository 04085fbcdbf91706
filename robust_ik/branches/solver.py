"""BranchSolver: all solutions of the poses of one frame in some rows, prepared once. Arrays only."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robust_ik.branches.closed_loop import ClosedLoop
from robust_ik.branches.free_rows import FreeRows
from robust_ik.branches.full_turns import with_turns
from robust_ik.branches.held_joints import HeldJoints
from robust_ik.branches.loop_plans import Loop, choose_plans
from robust_ik.branches.result import AllSolutions, ManySolutions, SelfMotion, SolutionsStatus
from robust_ik.branches.screw_axes import ScrewAxes
from robust_ik.branches.self_motion import Traced, trace, within_limits
from robust_ik.checks import Array
from robust_ik.kernels.branches import branches_layout as lay
from robust_ik.kinematics.chain import Chain
from robust_ik.kinematics.svd import singular_values
from robust_ik.kinematics.twist_rows import ROWS

SINGULAR = 1e-6
"""Least pivot of a Jacobian over its largest one up to which a solution is called singular; so are singular values."""
STATUS = {
    lay.EVERY: SolutionsStatus.EVERY,
    lay.NEARBY: SolutionsStatus.DEGENERATE,
    lay.DOUBTFUL: SolutionsStatus.DOUBTFUL,
    lay.DEGENERATE: SolutionsStatus.DOUBTFUL,
}
SAME = 1e-5
"""Solutions of a search that differ by less from one that is known are that one, rad and units of length."""
REACHED = 1e-11
"""Largest entry of the error of what a search finds and Newton's method has put right, rad and units of length."""
STILL = 1e-6
"""Joints that move by less along a curve stand still, rad and units of length."""
HELD = 2
"""How many joints of a redundant arm are held in turn."""


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

    def __reduce__(self) -> tuple[Any, ...]:
        # Through the constructor: what was prepared holds compiled functions.
        return type(self), tuple(getattr(self, each.name) for each in fields(self))

    @cached_property
    def arm(self) -> ScrewAxes | None:
        """The arm's joints; None if the loop has no form of its own, e.g. where a joint follows another one."""
        arm = ScrewAxes.of(self.chain)
        return None if arm is None else self.free.suited(arm)

    @cached_property
    def free(self) -> FreeRows:
        """What the rows leave free."""
        return FreeRows.of(self.rows)

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
        if not len(self.plans) or self.free.changes_targets:
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
        if self.arm is not None:
            columns, loop = self.arm.columns, self._closed_loop(target)
            exact = [loop.settled(loop.closed(each))[0][: len(columns)] for each in values[:, columns] / self.units]
            values[:, columns] = np.clip(np.array(exact).reshape(-1, len(columns)), loop.lower, loop.upper) * self.units
        return AllSolutions(
            self.to_q(values),
            self.to_q(values[:0]),
            SolutionsStatus.SEARCHED,
            np.zeros(len(values), dtype=bool),
            (),
            self.method,
        )

    def with_turns(self, found: AllSolutions, values: Array, near: Array) -> AllSolutions:
        """Solutions, whose joint values are (s, n), with every full turn of joints that stays within finite limits.

        Those nearest to `near`, (n,), come first.

        Raises:
            InputError: There are too many.
        """
        every, source = with_turns(values, self.lower, self.upper, self.turning)
        order = np.argsort(np.linalg.norm(every - near, axis=1), kind="stable")
        return replace(found, q=self.to_q(every[order]), singular=found.singular[source[order]])

    @cached_property
    def turning(self) -> NDArray[np.bool_]:
        """Joints that may turn by 2π within finite limits without moving the frame, (n,)."""
        return self.turns_freely & np.isfinite(self.lower) & np.isfinite(self.upper)

    @cached_property
    def turns_freely(self) -> NDArray[np.bool_]:
        """Joints whose full turns leave the frame where it is, as far as limits allow them, (n,)."""
        turns = np.zeros(len(self.lower), dtype=bool)
        if self.arm is not None:
            turns[self.arm.columns[~self.arm.slides]] = True
        return turns

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

    def joint_solutions(self, targets: Array, near: Array) -> tuple[Array, NDArray[np.int_], NDArray[np.bool_]]:
        """Joint values of the solutions within limits of poses (N, 4, 4), for callers that go through many poses.

        Of self-motions they are samples: where one joint has one of the values that are tried.

        Args:
            targets: The poses, checked.
            near: Joint values that turns are chosen next to, (n,).

        Returns:
            Joint values (N, s, n), whatever beyond those found; how many are found, (N,); whether they are all, (N,).
        """
        if len(self.plans):
            values, _, numbers = self._ask(targets, near[None])
            counts = numbers[:, lay.ALLOWED].astype(int)
            return values[:, : max(1, counts.max(initial=0))], counts, numbers[:, lay.VERDICT] == lay.EVERY
        if self.is_redundant and self.held is not None:
            assert self.arm is not None
            own, counts = self.held.samples(self.free.reachable(targets, self.arm.home))
            values = np.broadcast_to(near, (*own.shape[:2], len(near))).copy()
            values[:, :, self.arm.columns] = own * self.units
            endless = self.turns_freely & ~(np.isfinite(self.lower) & np.isfinite(self.upper))
            turned = values + 2 * np.pi * np.round((near - values) / (2 * np.pi))
            values = np.where(endless, turned, values)
            return values, counts, np.zeros(len(targets), dtype=bool)
        each = [self.search(T, near) for T in targets]
        most = max([len(one) for one in each] + [1])
        values = np.array([np.resize(one, (most, len(near))) if len(one) else np.tile(near, (most, 1)) for one in each])
        return values, np.array([len(one) for one in each]), np.zeros(len(targets), dtype=bool)

    def _ask(self, targets: Array, near: Array) -> tuple[Array, Array, Array]:
        """Calls the kernel for poses (N, 4, 4): joint values, rows and numbers."""
        from robust_ik.kernels.branches import branches

        count, n = len(targets), self.chain.n
        values, found = np.zeros((count, lay.SOLUTIONS, n)), np.zeros((count, lay.SOLUTIONS, lay.ROW))
        numbers = np.zeros((count, lay.NUMBERS))
        assert self.arm is not None
        poses = np.ascontiguousarray(self.free.reachable(targets, self.arm.home))
        branches.compiled(self.plans, self._packed, poses, np.ascontiguousarray(near), values, found, numbers)
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
                found = _pieces(loop, self._joints(row, loop), close, known)
                if found is not None:
                    pieces += found
                    inside += [_with_joints(row, piece.nearest(loop, close)) for piece in found]
                    beyond += [row] if not found else []
                    continue
            (inside if row[lay.INSIDE] > 0 else beyond).append(row)
        if degenerate:
            inside += self._searched(target, near, [*inside, *beyond], known, pieces, loop)
        inside.sort(key=lambda row: float(np.linalg.norm(row[:own] - close)))
        made = np.array([*inside, *beyond]).reshape(-1, lay.ROW)
        return made, len(inside), [self.curve(one, near) for one in pieces]

    def _searched(
        self, target: Array, near: Array, kept: list[Array], known: list[Traced], pieces: list[Traced], loop: ClosedLoop
    ) -> list[Array]:
        """Rows of solutions that a search finds beside those kept and on curves; it adds pieces of curves it meets.

        Beside a continuum that just misses the pose a search finds much that nearly reaches it: that is left out.
        """
        assert self.arm is not None
        own, close = len(self.units), near[self.arm.columns] / self.units
        made: list[Array] = []
        for start in self.search(target, near)[:, self.arm.columns] / self.units:
            values, error = loop.settled(loop.closed(start))
            if error > REACHED:
                continue
            far = [np.abs(loop.difference(row[:own], values[:own])).max() for row in [*kept, *made]]
            if min(far, default=np.inf) < SAME or any(curve.holds(loop, values[:own]) for curve in [*known, *pieces]):
                continue
            row, s = np.ones(lay.ROW), singular_values(loop.state(values)[1])
            row[lay.SIGMA] = s[-1] / s[0]
            found = _pieces(loop, values, close, known) if row[lay.SIGMA] < SINGULAR else None
            if found is None:
                made.append(_with_joints(row, np.clip(values[:own], loop.lower, loop.upper)))
            else:
                pieces += found
                made += [_with_joints(row, piece.nearest(loop, close)) for piece in found]
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
        (g,) = arm.motors(self.free.reachable(target, arm.home)[None])
        floating = self.free.joints_at(arm.point, g)
        axes = np.array([*arm.axes, *(axis for axis, _ in floating)])
        slides = np.array([*arm.slides, *(slides for _, slides in floating)])
        low, high = self.lower[arm.columns] / self.units, self.upper[arm.columns] / self.units
        return ClosedLoop(axes, slides, g, arm.point, self.free.rotates, self.free.wanted, low, high)

    def curve(self, traced: Traced, near: Array) -> SelfMotion:
        """A traced curve in the robot's configurations."""
        assert self.arm is not None
        columns = self.arm.columns
        values = np.repeat(near[None], len(traced.values), axis=0)
        values[:, columns] = traced.values[:, : len(columns)] * self.units
        moving = np.ptp(values[:, columns] / self.units, axis=0) > STILL
        q = self.to_q(values)
        J = self.chain.jacobians(q, "local_world_aligned")[..., [ROWS.index(row) for row in self.rows], :]
        s = singular_values(J)
        rank = int((s > SINGULAR * s[:, :1]).sum(axis=1).max())
        names = tuple(self.names[column] for column, moves in zip(columns, moving) if moves)
        return SelfMotion(q, traced.closed, names, s[:, rank - 1])

    def _by_self_motions(self, target: Array, near: Array) -> AllSolutions:
        assert self.held is not None
        assert self.arm is not None
        loop = self._closed_loop(target)
        traced = self.held.curves(loop)
        curves = tuple(self.curve(one, near) for one in traced)
        best = [one.nearest(loop, near[self.arm.columns] / self.units) * self.units for one in traced]
        values = np.repeat(near[None], len(best), axis=0)
        if best:
            values[:, self.arm.columns] = best
        order = np.argsort(np.linalg.norm(values - near, axis=1), kind="stable")
        q = self.to_q(values[order])
        return AllSolutions(
            q, q[:0], SolutionsStatus.CURVES, np.zeros(len(q), dtype=bool), tuple(curves[i] for i in order), self.method
        )


def _pieces(loop: ClosedLoop, values: Array, close: Array, known: list[Traced]) -> list[Traced] | None:
    """What limits leave of the self-motion through a singular solution, which `known` is told; None if it is alone."""
    traced = trace(loop.free, values)
    if not isinstance(traced, Traced):
        return None
    known.append(traced)
    return within_limits(loop, traced, close)


def _with_joints(row: Array, values: Array) -> Array:
    """The row with other joint values, within limits."""
    made = row.copy()
    made[: len(values)], made[lay.INSIDE] = values, 1.0
    return made
