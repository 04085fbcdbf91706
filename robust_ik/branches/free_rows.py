"""What wanted rows leave free of a pose: slides along world axes, turns about them. Arrays only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

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

    def suits(self, arm: ScrewAxes) -> bool:
        """Whether an arm turns about the kept axis alone, if one is kept: its tilt is then the same everywhere."""
        if self.kept is None:
            return True
        turning = arm.axes[~arm.slides, 1:4]
        return bool((np.linalg.norm(np.cross(turning, np.eye(3)[self.kept]), axis=1) < PARALLEL).all())

    def reachable(self, T: Array, home: Array) -> Array:
        """The targets, (..., 4, 4), with the tilt of an arm whose pose at zero is `home`, if one axis is kept.

        The rotation from the arm's tilt is a turn about the kept axis, which stays, and one about an axis across it.
        """
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
        slides = [(slide(np.eye(3)[i]), True) for i in self.sliding]
        return slides + [(line(np.eye(3)[i], point), False) for i in self.spinning]

    @property
    def turned(self) -> list[bool]:
        """Which of `joints` have a direction that matters: three slides, and three turns, have the same in any."""
        return [len(self.sliding) < 3] * len(self.sliding) + [len(self.spinning) < 3] * len(self.spinning)

    def joints_at(self, point: Array, g: Array) -> list[tuple[Array, bool]]:
        """The joints that float behind a displacement g, (8,), without three free turns, which leave all rotations."""
        back = ONE * 0
        back[:4] = g[:4] * np.array([1, -1, -1, -1])
        made = []
        for axis, slides in self.joints(np.zeros(3)):
            part = axis[5:] if slides else axis[1:4]
            direction = moved(back, line(part, np.zeros(3)))[1:4]
            if slides:
                made.append((slide(direction), True))
            elif len(self.spinning) == 1:
                made.append((line(direction, point), False))
        return made
