"""Self-motions of an arm: joints are held at many values in turn, and curves traced from the solutions of the rest.

A self-motion that crosses one of the tried values of a joint that it moves is found, since all solutions with that
joint held are. So are those of an arm without a joint too many at a degenerate pose. Arrays only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.branches.closed_loop import ClosedLoop
from robust_ik.branches.dual_quaternions import ONE, pose_of
from robust_ik.branches.loop_plans import Loop, choose_plans
from robust_ik.branches.screw_axes import ScrewAxes
from robust_ik.branches.self_motion import Traced, trace
from robust_ik.checks import Array
from robust_ik.kernels.branches import branches_layout as lay
from robust_ik.kinematics.svd import full_svd

VALUES = 48
"""At how many values a joint is held."""


@dataclass(frozen=True, eq=False)
class HeldJoint:
    """A joint that is held, and the arm's plans at each of its values.

    Attributes:
        joint: Its place in the chain.
        values: In units of the axes, (v,).
        plans: (v, k, SIZE).
        arms: The rest of the arm for kernels, (v, ARM).
    """

    joint: int
    values: Array
    plans: Array
    arms: Array


@dataclass(frozen=True, eq=False)
class HeldJoints:
    """An arm whose self-motions are found by holding joints.

    Attributes:
        arm: Its joints.
        held: Joints that are held in turn.
    """

    arm: ScrewAxes
    held: tuple[HeldJoint, ...]

    @classmethod
    def of(
        cls, arm: ScrewAxes, rows: Sequence[str], lower: Array, upper: Array, count: int
    ) -> HeldJoints | None:  # fmt: skip
        """The arm, if a joint can be held so that the rest is solved; else None.

        Args:
            arm: Its joints.
            rows: Wanted rows.
            lower: Limits of its joints, rad or m.
            upper: The same.
            count: How many joints are held in turn, at most.
        """
        held: list[HeldJoint] = []
        units = arm.units
        low, high = lower / units, upper / units
        for joint in _by_share(arm):
            if len(held) == count:
                break
            rest = Loop.of(arm.locked(joint, 0.3 * units[joint]), rows)
            if rest is None:
                return None
            free = np.full(len(arm.axes) - 1, np.inf)
            best = choose_plans(rest, -free, free)[:1]
            if not len(best):
                continue
            whole = not arm.slides[joint] and high[joint] - low[joint] >= 2 * np.pi
            a, b = (-np.pi, np.pi) if whole else (low[joint], high[joint])
            if not np.isfinite(b - a):
                continue
            values = a + (b - a) * (np.arange(VALUES) + 0.5) / VALUES
            keep = np.arange(len(arm.axes)) != joint
            plans, arms = [], []
            for value in values:
                others = arm.locked(joint, float(value * units[joint]))
                loop = Loop.of(others, rows)
                assert loop is not None
                arms.append(others.packed(len(others.axes)))
                plans.append(
                    [
                        loop.plan(
                            triple=bool(one[lay.TRIPLE]),
                            first=int(one[lay.FIRST]),
                            pivot=int(one[lay.PIVOT]),
                            lower=low[keep],
                            upper=high[keep],
                        )
                        for one in best
                    ]
                )
            held.append(HeldJoint(joint, values, np.array(plans), np.array(arms)))
        return cls(arm, tuple(held)) if held else None

    def curves(self, loop: ClosedLoop) -> list[Traced]:
        """The self-motions through the values that are tried, within limits."""
        from robust_ik.kernels.branches import branches

        known: list[Traced] = []
        count = len(self.arm.axes)
        target = (pose_of(loop.g, self.arm.scale) @ self.arm.home)[None]
        found, numbers = np.zeros((1, lay.SOLUTIONS, lay.ROW)), np.zeros((1, lay.NUMBERS))
        joints, near = np.zeros((1, lay.SOLUTIONS, count - 1)), np.zeros((1, count - 1))
        for held in self.held:
            for value, plans, arm in zip(held.values, held.plans, held.arms):
                branches.compiled(plans, arm, target, near, joints, found, numbers)
                first = lay.JOINTS - int(plans[0, lay.FLOATING])
                for row in found[0, : int(numbers[0, lay.ALLOWED])]:
                    own = np.insert(row[: count - 1], held.joint, value)
                    if any(one.holds(loop, own) for one in known):
                        continue
                    start = np.concatenate([own, row[first : first + len(loop.axes) - count]])
                    traced = trace(loop, start)
                    if isinstance(traced, Traced):
                        known.append(traced)
        return known

    def samples(self, targets: Array) -> tuple[Array, NDArray[np.int_]]:
        """Solutions within limits with the first held joint at each of its values, for poses (N, 4, 4).

        Returns:
            Values of the arm's joints, (N, s, count), in units of the axes, and how many each pose has, (N,).
        """
        from robust_ik.kernels.branches import branches

        (held, *_), many, rest = self.held, len(targets), len(self.arm.axes) - 1
        found, numbers = np.zeros((many, lay.SOLUTIONS, lay.ROW)), np.zeros((many, lay.NUMBERS))
        joints, near, poses = np.zeros((many, lay.SOLUTIONS, rest)), np.zeros((1, rest)), np.ascontiguousarray(targets)
        places, rows = [], []
        for value, plans, arm in zip(held.values, held.plans, held.arms):
            branches.compiled(plans, arm, poses, near, joints, found, numbers)
            place, which = np.nonzero(np.arange(lay.SOLUTIONS) < numbers[:, lay.ALLOWED, None])
            places.append(place)
            rows.append(np.insert(found[place, which, :rest], held.joint, value, axis=1))
        place = np.concatenate(places)
        order = np.argsort(place, kind="stable")
        counts = np.bincount(place, minlength=many)
        values = np.zeros((many, max(1, counts.max(initial=0)), rest + 1))
        column = np.arange(len(order)) - np.repeat(np.cumsum(counts) - counts, counts)
        values[place[order], column] = np.concatenate(rows)[order]
        return values, counts


def _by_share(arm: ScrewAxes) -> list[int]:
    """The joints of the arm, those that self-motions move most first."""
    rng = np.random.default_rng(5)
    share = np.zeros(len(arm.axes))
    for _ in range(20):
        values = rng.uniform(-2, 2, len(arm.axes)) * np.where(arm.slides, 0.2, 1.0)
        none = np.zeros(0)
        every = np.ones(3, dtype=bool)
        loop = ClosedLoop(arm.axes, arm.slides, ONE, arm.point, rotates=True, wanted=every, lower=none, upper=none)
        share += np.abs(full_svd(loop.state(values)[1]).Vt[-1])
    return [int(i) for i in np.argsort(-share, kind="stable")]
