"""Jacobians of many configurations at once, and the contractions of their derivatives that a search needs.

Of joint values alone: where the joints that they move stand in a robot's q plays no part. Arrays only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_parameter, readonly
from robust_ik.errors import InputError
from robust_ik.kinematics.chain import Chain
from robust_ik.kinematics.svd import singular_values
from robust_ik.kinematics.twist_rows import ROWS, checked_rows
from robust_ik.singularities.geometry.constants import constants, ranges

if TYPE_CHECKING:
    from robust_ik.robot.robot import Robot

REFERENCE = "local_world_aligned"
SIZED, VANISHING = 20, 1e-3


@dataclass(frozen=True, eq=False)
class ScrewChain:
    """The c joints that move a tip, as constants; its kinematics are functions of joint values.

    The reference of its Jacobians is LOCAL_WORLD_ALIGNED: the tip's point, the world's axes.

    Attributes:
        joint_names: The n independent joints.
        rows: Task rows.
        length_scale: Length by which linear rows are divided, m; 1 leaves them as they are.
        rotations: From each joint's axis frame (z is the axis) to the next one's at zero, (c, 3, 3).
        offsets: Origins of the axis frames in the one before, m, (c, 3).
        sliding: Which of the c joints slide.
        tip: The tip's point in the last axis frame, m, (3,).
        mixing: Motions of the c joints = mixing @ values, (c, n); a mimic joint shares its source's column.
        lower: Lower ends of the ranges to search, (n,): −π, or the limit of a sliding joint.
        upper: Upper ends.
        period: After how much each value comes back to the same pose, 2π; infinite where it does not, (n,).
    """

    joint_names: tuple[str, ...]
    rows: tuple[str, ...]
    length_scale: float
    rotations: Array
    offsets: Array
    sliding: tuple[bool, ...]
    tip: Array
    mixing: Array
    lower: Array
    upper: Array
    period: Array

    def __post_init__(self) -> None:
        for name in ("rotations", "offsets", "tip", "mixing", "lower", "upper", "period"):
            object.__setattr__(self, name, readonly(getattr(self, name)))
        if (np.count_nonzero(self.mixing, axis=1) > 1).any():
            raise InputError(f"every joint must follow one independent joint, got a mixing of {self.mixing.tolist()}")

    @classmethod
    def of(cls, robot: Robot, *, rows: Sequence[str] | None = None, length_scale: float = 1.0) -> ScrewChain:
        """The chain that moves a robot's tip.

        Args:
            robot: Any robot with a tip.
            rows: Task rows; default the robot's.
            length_scale: Length by which linear rows are divided, m.

        Raises:
            TipError: The robot was loaded whole, without a tip.
            InputError: There are no such rows, or the length is not positive.
        """
        frames, sliding, mixing = constants(robot)
        lower, upper, period = ranges(robot, sliding, mixing)
        return cls(
            joint_names=robot.joint_names,
            rows=robot.rows if rows is None else checked_rows(rows),
            length_scale=checked_parameter("length_scale", length_scale, above=0),
            rotations=frames[:-1, :3, :3],
            offsets=frames[:-1, :3, 3],
            sliding=tuple(bool(each) for each in sliding),
            tip=frames[-1, :3, 3],
            mixing=mixing,
            lower=lower,
            upper=upper,
            period=period,
        )

    @property
    def n(self) -> int:
        """Number of independent joints."""
        return len(self.joint_names)

    @property
    def m(self) -> int:
        """Number of task rows."""
        return len(self.rows)

    @cached_property
    def least_scale(self) -> float:
        """What stands for σ₁ where that is smaller, so that a Jacobian that vanishes is seen: .001 of its median."""
        s = singular_values(self.jacobian(self.random(np.random.default_rng(0), SIZED)))
        return float(VANISHING * np.median(s[:, 0]))

    def random(self, rng: np.random.Generator, size: int) -> Array:
        """Uniform joint values within the ranges to search, (size, n): a full turn, whatever the limits."""
        return rng.uniform(self.lower, self.upper, (size, self.n))

    def wrapped(self, values: Array) -> Array:
        """The same poses with angles in [−π, π), (..., n)."""
        turns = np.where(np.isfinite(self.period), np.floor(values / self.period + 0.5), 0.0)
        return np.asarray(values - turns * np.where(np.isfinite(self.period), self.period, 0.0))

    @cached_property
    def joints(self) -> Chain:
        """The same in all six rows, in metres, as compiled code reads it; q are the joint values."""
        each, column = np.arange(len(self.sliding)), np.argmax(self.mixing != 0, axis=1)
        tip = np.eye(4)
        tip[:3, 3] = self.tip
        return Chain(
            n=self.n,
            nq=self.n,
            rotations=self.rotations,
            origins=self.offsets,
            sliding=np.array(self.sliding),
            column=column,
            factor=self.mixing[each, column],
            shift=np.zeros(len(each)),
            place=column,
            circling=np.zeros(len(each), dtype=bool),
            tip=tip,
        )

    @cached_property
    def _rows(self) -> tuple[list[int], Array]:
        """The rows of a whole Jacobian that are looked at, and their factors, (m,)."""
        chosen = [ROWS.index(row) for row in self.rows]
        return chosen, np.where(np.array(chosen) < 3, 1 / self.length_scale, 1.0)

    def jacobian(self, values: ArrayLike) -> Array:
        """The Jacobian in `rows`, those of lengths divided by `length_scale`: (..., n) → (..., m, n)."""
        rows, factors = self._rows
        J = self.joints.jacobians(as_array(values, "values", (self.n,)), REFERENCE)
        return np.asarray(J[..., rows, :] * factors[:, None])

    def hessian(self, values: ArrayLike) -> Array:
        """∂J_ij/∂q_k, (..., n) → (..., m, n, n)."""
        rows, factors = self._rows
        H = self.joints.hessians(as_array(values, "values", (self.n,)), REFERENCE)
        return np.asarray(H[..., rows, :, :] * factors[:, None, None])

    def contraction(self, values: Array, left: Array, right: Array) -> Array:
        """Uᵀ (∂J/∂q_k) V for every k without ∂J/∂q.

        Args:
            values: Of N configurations, (N, n).
            left: Columns of U, (N, m, a).
            right: Columns of V, (N, n, b).

        Returns:
            (N, a, b, n).
        """
        rows, factors = self._rows
        wrenches = np.zeros((len(left), left.shape[2], 6))
        wrenches[..., rows] = np.swapaxes(left, 1, 2) * factors
        return self.joints.contractions(values, wrenches, np.swapaxes(right, 1, 2))

    def last_axes(self, values: Array) -> Array:
        """The last joint's axis frame after it has moved, world axes, (..., n) → (..., 3, 3)."""
        return self.joints.poses(values)[..., :3, :3]
