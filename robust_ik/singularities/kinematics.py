"""Jacobians of many configurations at once, and the contractions of their derivatives that a search needs.

A chain is a product of exponentials (Murray, Li, Sastry 1994, eq. (3.3)) with each axis turned to z, so that a joint
costs one product by a constant rotation and one by a planar one. NumPy only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_parameter, readonly
from robust_ik.linalg import singular_values
from robust_ik.rows import ROWS, checked_rows
from robust_ik.singularities.constants import axis_frames, ranges, screws_at_zero

if TYPE_CHECKING:
    from robust_ik.robot import Robot

SIZED, VANISHING = 20, 1e-3


@dataclass(frozen=True, eq=False)
class Screws:
    """What each joint of N chains does to the tip, world axes: its linear and angular velocity per unit speed.

    Attributes:
        linear: (3, N, c).
        angular: (3, N, c), zero for joints that slide.
    """

    linear: Array
    angular: Array


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
        axes, points, sliding, mixing, tip = screws_at_zero(robot)
        rotations, offsets, last = axis_frames(axes, points, tip)
        lower, upper, period = ranges(robot, np.array(sliding), mixing)
        return cls(
            joint_names=robot.joint_names,
            rows=robot.rows if rows is None else checked_rows(rows),
            length_scale=checked_parameter("length_scale", length_scale, above=0),
            rotations=rotations,
            offsets=offsets,
            sliding=sliding,
            tip=last,
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

    def jacobian(self, values: ArrayLike) -> Array:
        """The Jacobian in `rows`, those of lengths divided by `length_scale`: (..., n) → (..., m, n)."""
        values = as_array(values, "values", (self.n,))
        J = self.jacobian_of(self.screws(values.reshape(-1, self.n)))
        return J.reshape(*values.shape[:-1], self.m, self.n)

    def hessian(self, values: ArrayLike) -> Array:
        """∂J_ij/∂q_k, (..., n) → (..., m, n, n)."""
        values = as_array(values, "values", (self.n,))
        flat = values.reshape(-1, self.n)
        every = np.broadcast_to(np.eye(self.m), (len(flat), self.m, self.m))
        columns = np.broadcast_to(np.eye(self.n), (len(flat), self.n, self.n))
        return self.contraction(self.screws(flat), every, columns).reshape(*values.shape[:-1], self.m, self.n, self.n)

    def screws(self, values: Array) -> Screws:
        """The c joint screws of N configurations, (N, n)."""
        count, moves = len(values), (values @ self.mixing.T).T
        axes, points = np.empty((2, len(self.sliding), 3, count))
        # Columns of the rotation so far come first: frame[i] is the image of unit vector i, (3, N).
        frame = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, count))
        point = np.zeros((3, count))
        for index, (slides, move) in enumerate(zip(self.sliding, moves)):
            point = point + np.tensordot(self.offsets[index], frame, 1)
            frame = (self.rotations[index].T @ frame.reshape(3, -1)).reshape(3, 3, count)
            axes[index], points[index] = frame[2], point
            if slides:
                point = point + move * frame[2]
            else:
                c, s = np.cos(move), np.sin(move)
                frame = np.stack([c * frame[0] + s * frame[1], c * frame[1] - s * frame[0], frame[2]])
        tip = point + np.tensordot(self.tip, frame, 1)
        return self._velocities(axes.transpose(1, 2, 0), (tip - points).transpose(1, 2, 0))

    def _velocities(self, axes: Array, arms: Array) -> Screws:
        turning = ~np.array(self.sliding)
        return Screws(np.where(turning, _cross(axes, arms), axes), axes * turning)

    def jacobian_of(self, screws: Screws) -> Array:
        """The Jacobians of N configurations, (N, m, n)."""
        twists = np.concatenate([screws.linear / self.length_scale, screws.angular])
        J = twists[[ROWS.index(row) for row in self.rows]].transpose(1, 0, 2)
        return np.asarray(J @ self.mixing)

    def contraction(self, screws: Screws, left: Array, right: Array) -> Array:
        """Uᵀ (∂J/∂q_k) V for every k without ∂J/∂q: sums over the joints before and after k.

        With v, w the joints' linear and angular velocities, ∂v_i/∂q_k = w_min(i,k) × v_max(i,k), and ∂w_i/∂q_k =
        w_k × w_i for k < i, else 0; this holds for sliding joints too, whose w is 0.

        Args:
            screws: Of N configurations.
            left: Columns of U, (N, m, a).
            right: Columns of V, (N, n, b).

        Returns:
            (N, a, b, n).

        Source: Almarkhi-Maciejewski, eq. (9), with p_i in the branch k < i.
        """
        U = np.zeros((6, len(left), 1, left.shape[-1]))
        U[[ROWS.index(row) for row in self.rows], :, 0] = left.transpose(1, 0, 2)
        force, torque = U[:3] / self.length_scale, U[3:]
        v, w = screws.linear[..., None], screws.angular[..., None]
        motion = (self.mixing @ right)[None]
        after_v = np.cumsum((v * motion)[:, :, ::-1], axis=2)[:, :, ::-1]
        turn = w * motion
        before_w = np.cumsum(turn, axis=2) - turn
        after_w = np.cumsum(turn[:, :, ::-1], axis=2)[:, :, ::-1]
        one = np.concatenate([_cross(force, w), _cross(v, force), _cross(torque, w)])
        other = np.concatenate([after_v, before_w, after_w])
        contracted = one.transpose(1, 2, 3, 0) @ other.transpose(1, 2, 0, 3)
        return np.asarray(contracted.transpose(0, 2, 3, 1) @ self.mixing)


def last_axes(chain: ScrewChain, values: Array) -> Array:
    """The last joint's axis frame after it has moved, world axes, (3, 3)."""
    R = np.eye(3)
    for turn, slides, move in zip(chain.rotations, chain.sliding, chain.mixing @ values):
        R = R @ turn
        if not slides:
            c, s = np.cos(move), np.sin(move)
            R = R @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    return R


def _cross(a: Array, b: Array) -> Array:
    """A × b along the first axis."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
