"""Plans: which joints of a closed loop are the group, and which variable is found first; chosen by trying them.

A loop has six joints: those of the arm, stand-ins that are locked at 0 where the arm has fewer joints than rows, and
stand-ins that float where a row is free. Arrays only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.branches.dual_quaternions import ONE, joint_motor, line, pose_of, product, unit
from robust_ik.branches.free_rows import FreeRows
from robust_ik.branches.screw_axes import ScrewAxes
from robust_ik.checks import Array
from robust_ik.kernels.branches import branches_layout as lay
from robust_ik.kinematics.svd import singular_values, whole_svd

SAME_GROUP = 1e-9
"""Largest entry of N times a motor of a third joint that belongs to the group. Chosen: above the rounding of axes."""
WEAK_SPAN = 1e-4
"""Least singular value of a group's basis over the largest one: two axes that coincide span less."""
TRIALS, USED = 16, 3
"""Configurations that each plan is tried on; how many plans are kept."""
TRUSTED = 0.5
"""Share of the trials that a plan must solve to be kept."""


@dataclass(frozen=True, eq=False)
class Loop:
    """Six joints that close a loop with a pose.

    Attributes:
        axes: (6, 8); those that are `turned` hold a world axis alone.
        slides: Which slide, (6,).
        turned: Which are given in world axes, through the tool's point, (6,).
        own: How many are the arm's own: the first ones.
        floating: How many are free: the last ones.
        arm: The arm.
    """

    axes: Array
    slides: NDArray[np.bool_]
    turned: NDArray[np.bool_]
    own: int
    floating: int
    arm: ScrewAxes

    @classmethod
    def of(cls, arm: ScrewAxes, rows: Sequence[str]) -> Loop | None:
        """The loop of an arm in some rows; None if it has more joints than rows."""
        if len(arm.axes) > len(rows):
            return None
        free = FreeRows.of(rows)
        floating = free.joints(arm.point)
        locked = 6 - len(arm.axes) - len(floating)
        rng = np.random.default_rng(7)
        stand_ins = []
        for _ in range(locked):
            direction = unit(rng.normal(size=3))
            stand_ins.append(line(direction, arm.point + rng.uniform(-0.5, 0.5, 3)))
        axes = np.array([*arm.axes, *stand_ins, *(axis for axis, _ in floating)])
        slides = np.array([*arm.slides, *[False] * locked, *(slides for _, slides in floating)])
        turned = np.array([False] * (6 - len(floating)) + free.turned)
        return cls(axes, slides, turned, len(arm.axes), len(floating), arm)

    def pose(self, values: Array) -> Array:
        """The pose at the values of the arm's own joints, in units of the axes, (own,) → (4, 4)."""
        M = ONE
        for axis, slides, value in zip(self.axes, self.slides, values):
            M = product(M, joint_motor(axis, float(value), bool(slides)))
        return pose_of(M, self.arm.scale) @ self.arm.home

    def span(self, first: int) -> Array:
        """A basis of what the pair of joints first, first + 1 spans, (8, 4)."""
        a, b = self.axes[first], self.axes[first + 1]
        return np.stack([ONE, b, a, product(a, b)], axis=-1)

    def is_weak(self, first: int) -> bool:
        """Whether the axes of a pair nearly coincide."""
        s = singular_values(self.span(first))
        return bool(s[2 if self.slides[first : first + 2].all() else 3] < WEAK_SPAN * s[0])

    def slides_turned(self, first: int) -> bool:
        """Whether a pair are two slides that float: what they span is known at each target."""
        return bool((self.turned & self.slides)[first : first + 2].all())

    def is_triple(self, first: int) -> bool:
        """Whether three neighbours move within what the last two of them span."""
        if self.turned[first : first + 3].any():
            return False
        S = self.span(first + 1)
        found = whole_svd(S)
        if found.s[-1] < WEAK_SPAN * found.s[0]:
            return False
        products = np.stack([product(self.axes[first], each) for each in S.T], axis=-1)
        return bool((np.abs(found.U[:, 4:].T @ products) < SAME_GROUP).all())

    def plan(self, *, triple: bool, first: int, pivot: int, lower: Array, upper: Array) -> Array:
        """A packed plan, see `kernels.branches.branches_layout`."""
        packed = np.zeros(lay.SIZE)
        packed[[lay.TRIPLE, lay.FIRST, lay.PIVOT]] = triple, first, pivot
        packed[[lay.OWN, lay.FLOATING]] = self.own, self.floating
        packed[lay.POINT : lay.POINT + 3] = self.arm.point
        packed[lay.AXES : lay.AXES + 48] = self.axes.ravel()
        packed[lay.SLIDES : lay.SLIDES + 6], packed[lay.TURNED : lay.TURNED + 6] = self.slides, self.turned
        packed[lay.LOWER : lay.LOWER + 6], packed[lay.UPPER : lay.UPPER + 6] = -np.inf, np.inf
        packed[lay.LOWER : lay.LOWER + self.own], packed[lay.UPPER : lay.UPPER + self.own] = lower, upper
        if triple or first < 5:
            S = self.span(first + triple)
            N = whole_svd(S).U[:, 4:].T
            if not S[:4, 1:].any():  # two slides: rotations vanish, and what is across both; the rest follows
                N = np.zeros((4, 8))
                N[[0, 1, 2], [1, 2, 3]] = 1.0
                N[3, 5:] = np.cross(S[5:, 1], S[5:, 2])
            packed[lay.SPANS : lay.SPANS + 32] = N.ravel()
            packed[lay.PARTS : lay.PARTS + 32] = np.linalg.pinv(S).ravel()
        return packed

    def candidates(self) -> list[tuple[bool, int, int]]:
        """Plans that can be tried: whether the group is a triple, its first joint, the place of the first variable."""
        found = []
        for first in range(4):
            if self.is_triple(first):
                found += [(True, first, place) for place in range(3)]
        for first in (5, 0, 1, 2, 3, 4):
            pair = [first, (first + 1) % 6]
            if first < 5 and (self.is_weak(first) or (self.turned[pair].any() and not self.slides_turned(first))):
                continue
            others = _others(False, first)
            found += [(False, first, place) for place in (0, 3) if not self.slides[others[place]]]
        return found


def _others(triple: bool, first: int) -> list[int]:
    """Joints outside the group, in the order of `kernels.branches.loop_equations.others`."""
    size = 3 if triple else 2
    if first + size > 6:
        return [4, 3, 2, 1]
    return [*range(first - 1, -1, -1), *range(5, first + size - 1, -1)]


def choose_plans(loop: Loop, lower: Array, upper: Array) -> Array:
    """The plans that find most on random configurations, triples first, then the least work; (k, SIZE), k may be 0."""
    from robust_ik.kernels.branches import branches

    rng = np.random.default_rng(11)
    values = rng.uniform(-np.pi, np.pi, (TRIALS, loop.own))
    low = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper - 1.0, -0.5))
    high = np.where(np.isfinite(upper), upper, low + 1.0)
    slides = loop.slides[: loop.own]
    values = np.where(slides, np.clip(low, -1e3, 1e3) + rng.uniform(size=values.shape) * (high - low), values)
    targets = np.array([loop.pose(each) for each in values])
    found, numbers = np.zeros((TRIALS, lay.SOLUTIONS, lay.ROW)), np.zeros((TRIALS, lay.NUMBERS))
    joints, arm, near = np.zeros((TRIALS, lay.SOLUTIONS, loop.own)), loop.arm.packed(loop.own), np.zeros((1, loop.own))
    kept, counts = [], []
    for triple, first, pivot in loop.candidates():
        plan = loop.plan(triple=triple, first=first, pivot=pivot, lower=lower, upper=upper)
        branches.compiled(plan[None], arm, targets, near, joints, found, numbers)
        sure = numbers[:, lay.VERDICT] == lay.EVERY
        if sure.mean() < TRUSTED:
            continue
        far = found[..., : loop.own] - values[:, None]
        far = np.where(slides, far, far - 2 * np.pi * np.round(far / (2 * np.pi)))
        same = np.abs(far).max(axis=-1) < 1e-5
        hit = (same & (np.arange(lay.SOLUTIONS) < numbers[:, lay.COUNT, None])).any(axis=1)
        work = float(np.median(numbers[:, lay.WORK]))
        kept.append((float((hit & sure).mean()), not triple, work, plan))
        counts.append(np.where(sure, numbers[:, lay.COUNT], 0))
    most = np.max(counts, axis=0) if counts else 0
    ranked = []
    for place, ((share, pair, work, _), count) in enumerate(zip(kept, counts)):
        score = round(share * float((count == most).mean()), 1)
        if score >= TRUSTED:
            ranked.append((-score, pair, work, place))
    used = [kept[place][3] for *_, place in sorted(ranked)[:USED]]
    return np.ascontiguousarray(used) if used else np.zeros((0, lay.SIZE))
