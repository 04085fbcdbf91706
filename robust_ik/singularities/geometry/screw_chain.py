"""ScrewChain: the joint axes of an arm as constants, and Jacobians of many configurations from them.

Its functions take joint values, not a robot's q. Arrays only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_ik.checks import Array, as_array, checked_parameter, readonly
from robust_ik.errors import InputError, TipError
from robust_ik.kinematics.chain import Chain
from robust_ik.kinematics.svd import singular_values
from robust_ik.kinematics.twist_rows import DEFICIENT, ROWS, checked_rows

if TYPE_CHECKING:
    from robust_ik.robot.robot import Robot


REFERENCE = "local_world_aligned"
SIZED, VANISHING = 20, 1e-3
"""Configurations whose median σ₁ is the usual one, and the fraction of it below which a Jacobian vanishes."""
FAR = 10.0
"""Slides with a longer travel, in sizes of the arm, or driven by more turns, are searched near the arm.

So are those without limits.

Chosen: what turns is to be seen beside what slides; a lift or a linear axis travels a few times the arm's size.
"""
SAMPLES = 20
"""Configurations that show the largest rank. A rank that is reached anywhere is reached nearly everywhere."""


@dataclass(frozen=True, eq=False)
class ScrewChain:
    """The c joints that move a tip, as constants; its kinematics are functions of joint values.

    The reference of its Jacobians is LOCAL_WORLD_ALIGNED: the tip's point, the world's axes.

    Attributes:
        joint_names: The n independent joints.
        rows: Task rows.
        length_scale: Length by which linear rows are divided, m: that of the arm itself, so that which configurations
            are singular does not depend on its size.
        rotations: From each joint's axis frame (z is the axis) to the next one's at zero, (c, 3, 3).
        offsets: Origin of each axis frame in the one before, m, (c, 3).
        sliding: Which of the c joints slide.
        tip: The tip's point in the last axis frame, m, (3,).
        mixing: Motions of the c joints = mixing @ values, (c, n); a mimic joint shares its source's column.
        lower: Lower ends of the ranges to search, (n,): −π, or the limit of a sliding joint.
        upper: Upper ends.
        period: Change of each value after which the pose is the same again, 2π; infinite if there is none, (n,).
        slides: Which of the n values are lengths; the others are angles, also where a slide follows them.
        rank: The rank of the Jacobian nearly everywhere; None if it is min(m, n).
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
    slides: tuple[bool, ...]
    rank: int | None = None

    def __post_init__(self) -> None:
        for name in ("rotations", "offsets", "tip", "mixing", "lower", "upper", "period"):
            object.__setattr__(self, name, readonly(getattr(self, name)))
        if (np.count_nonzero(self.mixing, axis=1) > 1).any():
            raise InputError(f"every joint must follow one independent joint, got a mixing of {self.mixing.tolist()}")

    @classmethod
    def of(cls, robot: Robot, *, rows: Sequence[str] | None = None, length_scale: float = 1.0) -> ScrewChain:
        """The chain that moves a robot's tip, with its largest rank: see `largest_rank`.

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
        chain = cls(
            joint_names=robot.joint_names,
            rows=robot.rows if rows is None else checked_rows(rows),
            length_scale=robot.length_scale,
            rotations=frames[:-1, :3, :3],
            offsets=frames[:-1, :3, 3],
            sliding=tuple(bool(each) for each in sliding),
            tip=frames[-1, :3, 3],
            mixing=mixing,
            lower=lower,
            upper=upper,
            period=period,
            slides=tuple(bool(each) for each in robot.sliding),
        )
        scale = checked_parameter("length_scale", length_scale, above=0)
        return replace(chain, length_scale=scale, rank=largest_rank(chain))

    def in_rows(self, rows: tuple[str, ...]) -> ScrewChain:
        """The same chain in other task rows, for its Jacobians: how large their rank is has not been looked at."""
        return replace(self, rows=rows, rank=None)

    @property
    def n(self) -> int:
        """Number of independent joints."""
        return len(self.joint_names)

    @property
    def m(self) -> int:
        """Number of task rows."""
        return len(self.rows)

    @property
    def full_rank(self) -> int:
        """The rank of the Jacobian where it is not singular, at most min(m, n): coranks are what is missing of it."""
        return min(self.m, self.n) if self.rank is None else self.rank

    @property
    def is_serial(self) -> bool:
        """Whether each joint moves by a value of its own: angles as they are, slides in any unit."""
        turns = ~np.array(self.slides)
        own = len(self.sliding) == self.n and bool(((self.mixing != 0) == np.eye(self.n, dtype=bool)).all())
        return own and bool((self.mixing[np.ix_(turns, turns)] == np.eye(sum(turns))).all())

    def measured_in(self, units: Array) -> ScrewChain:
        """The same chain with joint values in other units.

        Args:
            units: The new unit of each value, in the present one, (n,).
        """
        ends = self.lower / units, self.upper / units, self.period / units
        return replace(self, mixing=self.mixing * units, lower=ends[0], upper=ends[1], period=ends[2])

    @cached_property
    def least_scale(self) -> float:
        """Least value of σ₁ as a scale, 0.001 of its median, so that a vanishing Jacobian is recognised."""
        s = singular_values(self.jacobian(self.random(np.random.default_rng(0), SIZED)))
        return float(VANISHING * np.median(s[:, 0]))

    def random(self, rng: np.random.Generator, size: int) -> Array:
        """Uniform joint values within the ranges to search, (size, n): a full turn, without regard to limits."""
        return rng.uniform(self.lower, self.upper, (size, self.n))

    def wrapped(self, values: Array) -> Array:
        """Joint values of the same poses, with angles in [−π, π), (..., n)."""
        turns = np.where(np.isfinite(self.period), np.floor(values / self.period + 0.5), 0.0)
        return np.asarray(values - turns * np.where(np.isfinite(self.period), self.period, 0.0))

    @cached_property
    def joints(self) -> Chain:
        """The same chain in all six rows, in metres, for compiled code; its q are the joint values."""
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
    def _rows(self) -> tuple[list[int] | slice, Array]:
        """Where the task rows are in a whole Jacobian, and their factors, (m,)."""
        chosen = [ROWS.index(row) for row in self.rows]
        return slice(None) if self.rows == ROWS else chosen, np.where(np.array(chosen) < 3, 1 / self.length_scale, 1.0)

    @cached_property
    def task(self) -> Array:
        """For compiled code, where each task row is in a whole Jacobian, and its factor, (m, 2)."""
        rows, factors = self._rows
        return readonly(np.stack([np.arange(len(ROWS))[rows], factors], axis=1))

    def jacobian(self, values: ArrayLike) -> Array:
        """The Jacobian in `rows`, linear rows divided by `length_scale`: (..., n) → (..., m, n)."""
        rows, factors = self._rows
        J = self.joints.jacobians(as_array(values, "values", (self.n,)), REFERENCE)[..., rows, :]
        return np.asarray(J * factors[:, None])

    def hessian(self, values: ArrayLike) -> Array:
        """∂J_ij/∂q_k, (..., n) → (..., m, n, n)."""
        rows, factors = self._rows
        H = self.joints.hessians(as_array(values, "values", (self.n,)), REFERENCE)
        return np.asarray(H[..., rows, :, :] * factors[:, None, None])

    def contraction(self, values: Array, left: Array, right: Array) -> Array:
        """Uᵀ (∂J/∂q_k) V for every k without ∂J/∂q.

        Args:
            values: Joint values of N configurations, (N, n).
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


Mask = NDArray[np.bool_]


def constants(robot: Robot) -> tuple[Array, Mask, Array]:
    """The constants of the joints that move a robot's tip.

    Args:
        robot: Any robot with a tip.

    Returns:
        Each joint's axis frame (z is the axis) in the one before with all values at zero, and the tip's in the last
        one, (c + 1, 4, 4); whether the joints slide, (c,); and their motions per motion of the independent joints, (c,
        n).

    Raises:
        TipError: The robot was loaded whole, without a tip.
    """
    if robot.tip is None:
        raise TipError(f"{robot.name} was loaded whole, without a tip: singularities are those of a chain to a tip")
    chain = robot.chain()
    frames, mixing = np.zeros((len(chain) + 1, 4, 4)), np.zeros((len(chain), robot.n))
    frames[:-1, :3, :3], frames[:-1, :3, 3], frames[:, 3, 3], frames[-1] = (
        chain.rotations,
        chain.origins,
        1.0,
        chain.tip,
    )
    mixing[np.arange(len(chain)), chain.column] = chain.factor
    for slides, shift, after in zip(chain.sliding, chain.shift, frames[1:]):
        # A mimic joint may not be at zero when its source is.
        moved = np.eye(4)
        if slides:
            moved[2, 3] = shift
        else:
            moved[:2, :2] = [[np.cos(shift), -np.sin(shift)], [np.sin(shift), np.cos(shift)]]
        after[:] = moved @ after
    return frames, chain.sliding, mixing


def axes_at_zero(rotations: Array, offsets: Array) -> tuple[Array, Array]:
    """The joints' axes with all of them at zero and a point on each, world, (c, 3) each.

    Args:
        rotations: From each joint's axis frame to the next one's, (c, 3, 3).
        offsets: Origin of each axis frame in the one before, (c, 3).
    """
    rotation, point = np.eye(3), np.zeros(3)
    axes, points = [], []
    for turned, offset in zip(rotations, offsets):
        point, rotation = point + rotation @ offset, rotation @ turned
        axes.append(rotation[:, 2])
        points.append(point)
    return np.array(axes), np.array(points)


def ranges(robot: Robot, sliding: Mask, mixing: Array) -> tuple[Array, Array, Array]:
    """The range of each joint for searches, and its period. Limits matter only for joints that slide.

    Args:
        robot: The robot.
        sliding: Which of the c joints that move the tip slide.
        mixing: Their motions per motion of the independent joints, (c, n).

    Returns:
        Lower and upper ends: a full turn, or for a sliding joint its limits, if they are not far apart, else two of the
        robot's units of length; and the change of each value after which the pose is the same again, infinite if there
        is none, (n,) each.
    """
    used = mixing != 0
    slides = (used & sliding[:, None]).any(axis=0)
    least = np.min(np.where(used, np.abs(mixing), 1.0), axis=0, initial=1.0)
    whole = (np.round(mixing) == mixing).all(axis=0)
    lengths = np.array(robot.sliding)
    low, high = _travel(
        robot.lower,
        robot.upper,
        np.where(lengths, robot.length_scale, np.pi),
        np.where(lengths, FAR * robot.size, FAR * 2 * np.pi),
    )
    period = np.where(whole & ~slides, 2 * np.pi, np.inf)
    return np.where(slides, low, -np.pi / least), np.where(slides, high, np.pi / least), period


def _travel(lower: Array, upper: Array, unit: Array, far: Array) -> tuple[Array, Array]:
    """Ends of the ranges of what slides: limits, or two units of value if there are none or they are far apart."""
    wide = ~(upper - lower <= far)
    middle = np.clip(0.0, np.where(np.isfinite(lower), lower + unit, -np.inf), np.inf)
    middle = np.clip(middle, -np.inf, np.where(np.isfinite(upper), upper - unit, np.inf))
    return np.where(wide, middle - unit, lower), np.where(wide, middle + unit, upper)


def largest_rank(chain: ScrewChain, deficient: float = DEFICIENT) -> int:
    """The rank of a chain's Jacobian at nearly all configurations.

    Slides are measured in the arm's own unit of length, which its `length_scale` must be. What rounding leaves of a
    singular value counts as nothing, beside what the joints move at all.

    Args:
        chain: The chain.
        deficient: Largest fraction of σ₁ in all rows that counts as nothing.
    """
    even = chain.measured_in(np.where(chain.slides, chain.length_scale, 1.0))
    whole = even.in_rows(ROWS).jacobian(even.random(np.random.default_rng(0), SAMPLES))
    s = singular_values(whole[:, [ROWS.index(row) for row in chain.rows]])
    return int(np.sum(s > deficient * singular_values(whole)[:, :1], axis=1).max())
