"""What wanted rows leave free of a pose: turns about world axes, and slides along them. Arrays only.

A reached pose M = S R g, with R a turn about a world axis through the target's point and S a slide along world axes,
closes the loop M (g⁻¹ R⁻¹ g) (g⁻¹ S⁻¹ g) = g: turns come first, and both are carried by g. Where all of the position is
free, axes are moved to meet in the tool's point instead, which stays there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from robust_ik.branches.dual_quaternions import ONE, line, moved, slide
from robust_ik.branches.screw_axes import ScrewAxes
from robust_ik.checks import Array
from robust_ik.kinematics.twist_rows import ROWS

PARALLEL = 1e-9
"""Sine of the angle between an axis and a row up to which a joint turns in that row alone."""


@dataclass(frozen=True)
class FreeRows:
    """The rows that are free, as indices 0, 1, 2 of world axes.

    Attributes:
        sliding: Axes along which the position is free.
        spinning: Axes about which the frame may turn: one or three of them. With two, `kept` says what is wanted.
        kept: The axis about which alone the rotation is wanted; None if none or several are.
    """

    sliding: tuple[int, ...]
    spinning: tuple[int, ...]
    kept: int | None

    @classmethod
    def of(cls, rows: Sequence[str]) -> Self:
        """What some rows, of x y z wx wy wz, leave free."""
        free = [i for i, row in enumerate(ROWS) if row not in rows]
        spinning = tuple(i - 3 for i in free if i > 2)
        kept = next(i for i in range(3) if i not in spinning) if len(spinning) == 2 else None
        return cls(tuple(i for i in free if i < 3), () if len(spinning) == 2 else spinning, kept)

    @property
    def turns_only(self) -> bool:
        """Whether nothing of the position is wanted."""
        return len(self.sliding) == 3

    @property
    def changes_targets(self) -> bool:
        """Whether `reachable` gives other targets."""
        return self.kept is not None or self.turns_only

    def suited(self, arm: ScrewAxes) -> ScrewAxes | None:
        """The joints whose loop is solved; None if an axis is kept and joints turn about others, or slides do nothing.

        An arm that turns about the kept axis alone has the same tilt everywhere.
        """
        turning = arm.axes[~arm.slides, 1:4]
        if self.kept is not None:
            across = np.linalg.norm(np.cross(turning, np.eye(3)[self.kept]), axis=1)
            if not (across < PARALLEL).all():
                return None
        if not self.turns_only:
            return arm
        if arm.slides.any():
            return None
        return replace(arm, axes=np.array([line(each, arm.point) for each in turning]))

    def reachable(self, T: Array, home: Array) -> Array:
        """The targets, (..., 4, 4), for the arm that is `suited`, whose pose at zero is `home`.

        If an axis is kept they have the arm's tilt: the rotation from there is a turn about the kept axis, which stays,
        and one about an axis across it. If all of the position is free it is that at zero.
        """
        if self.turns_only:
            T = np.array(T)
            T[..., :3, 3] = home[:3, 3]
        if self.kept is None:
            return T
        k, i, j = self.kept, (self.kept + 1) % 3, (self.kept + 2) % 3
        R = T[..., :3, :3] @ home[:3, :3].T
        angle = np.arctan2(R[..., j, i] - R[..., i, j], R[..., i, i] + R[..., j, j])
        turned = np.zeros_like(R)
        turned[..., k, k] = 1.0
        turned[..., i, i] = turned[..., j, j] = np.cos(angle)
        turned[..., j, i], turned[..., i, j] = np.sin(angle), -np.sin(angle)
        made = np.array(T)
        made[..., :3, :3] = turned @ home[:3, :3]
        return made

    def joints(self, point: Array) -> list[tuple[Array, bool]]:
        """Joints that float, with an axis in world axes through the tool's point: axis (8,), and whether it slides."""
        turns = [(line(np.eye(3)[i], point), False) for i in self.spinning]
        return turns if self.turns_only else turns + [(slide(np.eye(3)[i]), True) for i in self.sliding]

    @property
    def turned(self) -> list[bool]:
        """Which of `joints` have a direction that matters: three turns have the same in any."""
        return [self.rotates] * len(self.spinning) + [True] * (0 if self.turns_only else len(self.sliding))

    @property
    def rotates(self) -> bool:
        """Whether any of the rotation is wanted."""
        return len(self.spinning) < 3

    @property
    def wanted(self) -> NDArray[np.bool_]:
        """Which coordinates of the position are wanted, (3,)."""
        return ~np.isin(np.arange(3), self.sliding)

    def joints_at(self, point: Array, g: Array) -> list[tuple[Array, bool]]:
        """The joints that float behind a displacement g, (8,); none where no rotation is wanted.

        A loop of the position alone has no place for slides: they would turn with the tool.
        """
        if not self.rotates:
            return []
        back = ONE * 0
        back[:4] = g[:4] * np.array([1, -1, -1, -1])
        made = []
        for axis, slides in self.joints(np.zeros(3)):
            part = axis[5:] if slides else axis[1:4]
            direction = moved(back, line(part, np.zeros(3)))[1:4]
            made.append((slide(direction), True) if slides else (line(direction, point), False))
        return made
