"""The second-order inverse: exact where it can be, calm out of reach, and able to leave exact singularities."""

from __future__ import annotations

import reprlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, as_measures, check_leading_axes, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, RobustInverse
from robust_ik.inverses.second_order.numpy_step import TOO_FAST, Remembered, numpy_step
from robust_ik.inverses.second_order.weak_rows import fade
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kernels.second_order.second_order_layout import (
    FLOOR,
    LAST,
    MEMORY_HEAD,
    MEMORY_JOINTS,
    MEMORY_ROWS,
    memory_size,
)
from robust_ik.kinematics.svd import LARGEST_COMPILED, svd


@dataclass(frozen=True)
class SecondOrder(RobustInverse):
    """Exact where all σ ≥ γσ₁; below, the lost rows follow σz + τ/2 K[z, z] = c, their model to second order.

    At a singularity no first-order rule moves along the lost direction, since the gradient vanishes: but where the
    curvature K leads the way that is wanted, this one moves to a side. Where it leads away, the target is out of reach
    and the arm comes to rest at the edge. Where there is none, a self-motion turns the lost direction, once the arm has
    waited for a quarter of a second. The look-ahead τ is the shortest that joint speed and acceleration limits can
    honour: it is not tuned.

    Up to 16 rows and joints a step is compiled, beyond that it is made in NumPy; so are a controller's steps, up to 15.

    `solve` has no Hessian: the lost rows are damped by what the command asks, λ = ‖c‖/(2 speed), so that their part of
    the motion stays below `speed`. Outside a run (`begin`) there is no last velocity and no turning.

    Watch for: joint limits are the resolver's, not of this inverse; `speed` and `acceleration` say how it plans. It
    uses the acceleration that it is given: give what you want to see, not what the drive can do. The gain of the task,
    1/s, times `horizon` should not be above 1. γ is relative: a task of one row is never weak, whatever its σ.

    Attributes:
        gamma: γ, the threshold relative to σ₁, below 1.
        speed: Joint speed limit, rad/s.
        acceleration: Joint acceleration limit, rad/s².
        horizon: The longest look-ahead, s.
        turn: Speed of the turning self-motion as a fraction of `speed`, 0 for none.

    Source: this project; second-order models of singular motion: Bedrossian 1990, Seng, O'Neil and Chen 1995.
    """

    source: ClassVar[str] = "this project; after Bedrossian 1990, Seng-O'Neil-Chen 1995"
    card: ClassVar[Card] = Card(
        formula="1/σ where σ ≥ γσ₁; below, least ‖σz + τGz + τ/2 K[z, z] − c‖² + zᵀμz",
        largest_gain="none; the weak part stays below 2 `speed`",
        gain_at_zero="0 along σ, √(2c/(κτ)) along the curvature",
        exact="σ ≥ γσ₁",
        continuity="continuous, but for the choice between two ways to serve what is lost",
    )
    gamma: float = 0.08
    speed: float = 2.0
    acceleration: float = 20.0
    horizon: float = 0.25
    turn: float = 1.0

    def __post_init__(self) -> None:
        checked_parameter("gamma", self.gamma, above=0, below=1)
        for name in ("speed", "acceleration", "horizon"):
            checked_parameter(name, getattr(self, name), above=0)
        checked_parameter("turn", self.turn, least=0)

    @classmethod
    def from_limits(cls, speed_limits: ArrayLike, acceleration_limits: ArrayLike | None = None) -> SecondOrder:
        """The inverse for the slowest of the joints.

        Args:
            speed_limits: (n,), rad/s; what is infinite does not count.
            acceleration_limits: (n,), rad/s²; default ten times the speed limits.

        Raises:
            InputError: No limit is finite, or one is not > 0.
        """
        speed = _least("speed_limits", speed_limits)
        if acceleration_limits is None:
            return cls(speed=speed, acceleration=10 * speed)
        return cls(speed=speed, acceleration=_least("acceleration_limits", acceleration_limits))

    @property
    def needs_hessian(self) -> bool:
        """Yes."""
        return True

    @property
    def relative(self) -> bool:
        """Yes."""
        return True

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """The velocity without curvature; see `RobustInverse.solve`."""
        J = as_array(J, "J", (None, None))
        xdot = as_measures(xdot, "xdot", (J.shape[-2],))
        check_leading_axes("J", J.shape[:-2], "xdot", xdot.shape[:-1])
        found = svd(J)
        largest = np.where(found.s[..., :1] > 0, found.s[..., :1], 1.0)
        s = found.s / largest
        c = (np.swapaxes(found.U, -1, -2) @ xdot[..., None])[..., 0] / largest
        w = fade(s / self.gamma)
        size = np.sqrt(np.sum((w * c) ** 2, axis=-1, keepdims=True))
        damping = w * (FLOOR**2 + (size / (2 * self.speed)) ** 2)
        squared = s**2 + damping
        z = np.where(squared > 0, s / np.where(squared > 0, squared, 1.0), 0.0) * c
        return np.asarray((z[..., None, :] @ found.Vt)[..., 0, :])

    def velocity(self, equation: TaskEquation) -> Array:
        """q̇ for ẋ as the first step of a run; of several equations, with leading axes, for each by itself.

        Raises:
            InputError: The equation has no Hessian.
        """
        J, H = np.asarray(equation.J), equation.hessian
        if J.ndim < 3 or H is None:
            return self.begin(0.0).velocity(equation)
        each = zip(J, np.asarray(equation.xdot), np.asarray(equation.error), np.asarray(H))
        return np.reshape([self.velocity(TaskEquation(*one)) for one in each], J.shape[:-2] + J.shape[-1:])

    def parameters(self, dt: float) -> Array:
        """The parameters of a step of dt seconds, (6,), as `numpy_step` and compiled code take them.

        Raises:
            InputError: dt is not a number ≥ 0.
        """
        dt = checked_parameter("dt", dt, least=0)
        return np.array([self.gamma, self.speed, self.acceleration, self.horizon, self.turn * self.speed, dt])

    def begin(self, dt: float) -> RobustInverse:
        """An inverse that keeps the last velocity and the turn from step to step, dt seconds apart."""
        return SecondOrderRun(self, self.parameters(dt))


class SecondOrderRun(RobustInverse):
    """A run of `SecondOrder`: an inverse that remembers.

    Attributes:
        inverse: What has begun it.
        parameters: Of its steps, (6,), see `SecondOrder.parameters`.
    """

    source: ClassVar[str] = SecondOrder.source
    card: ClassVar[Card] = SecondOrder.card

    def __init__(self, inverse: SecondOrder, parameters: Array) -> None:
        self.inverse, self.parameters = inverse, parameters
        self._shape, self._memory, self._remembered = (0, 0), np.empty(0), Remembered(np.empty(0))

    @property
    def needs_hessian(self) -> bool:
        """Yes."""
        return True

    @property
    def relative(self) -> bool:
        """Yes."""
        return True

    def begin(self, dt: float) -> RobustInverse:
        """A run that remembers nothing of this one."""
        return self.inverse.begin(dt)

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """See `SecondOrder.solve`; nothing is remembered."""
        return self.inverse.solve(J, xdot)

    def velocity(self, equation: TaskEquation) -> Array:
        """q̇ for ẋ as the next step of the run.

        Raises:
            InputError: The equation has no Hessian, or the velocities are too large to be numbers.
        """
        if equation.hessian is None:
            raise InputError("SecondOrder needs the Hessian ∂J/∂q of the task, the equation has none")
        J = as_array(equation.J, "J", (None, None))
        m, n = J.shape
        H = as_array(equation.hessian, "hessian", (m, n, n))
        xdot = as_measures(equation.xdot, "xdot", (m,))
        if self._shape != (m, n):  # a level may be given a joint or a row more
            self._begin_anew(m, n)
        if max(m, n) > LARGEST_COMPILED:
            self._remembered = numpy_step(self.parameters, J, xdot, H, self._remembered)
            return self._remembered.last
        out = np.empty(n)
        J, xdot, H = (np.ascontiguousarray(each) for each in (J, xdot, H))
        if not _compiled(max(m, n) <= 8)(J, xdot, H, self.parameters, self._memory, out):
            raise InputError(TOO_FAST)
        return out

    def _begin_anew(self, m: int, n: int) -> None:
        """Forgets the turn and, with other joints, the last velocities."""
        last = self._last if self._shape[1] == n else np.zeros(n)
        self._shape, self._memory, self._remembered = (m, n), np.zeros(memory_size(m, n)), Remembered(last)
        self._memory[LAST : LAST + n] = last

    def tell(self, m: int, n: int, to: Array) -> None:
        """Tells what is remembered to a level of m rows, of a stack for n joints, in compiled code.

        Args:
            m: Number of rows.
            n: Number of joints.
            to: Filled: see `second_order_layout.MEMORY_ROWS`.
        """
        to[:MEMORY_HEAD], told = self._shape, to[MEMORY_HEAD:]
        if self._shape == (m, n):
            told[:] = self._memory
            return
        told[:] = 0.0
        if self._shape[1] >= n:
            for here, there, count in _parts((m, n), self._shape):
                told[here : here + count] = self._memory[there : there + count]

    def remember(self, m: int, n: int, told: Array) -> None:
        """Remembers what such a level tells after a step; nothing if the step did not need this inverse."""
        rows, joints = shape = int(told[MEMORY_ROWS]), int(told[MEMORY_JOINTS])
        if shape == self._shape == (m, n):
            self._memory[:] = told[MEMORY_HEAD:]
        elif shape in ((m, n), (m + 1, n + 1)):
            self._shape, self._memory = shape, np.zeros(memory_size(rows, joints))
            for here, there, count in _parts((m, n), shape):
                self._memory[there : there + count] = told[MEMORY_HEAD + here : MEMORY_HEAD + here + count]

    @property
    def _last(self) -> Array:
        """The last velocities, (n,)."""
        m, n = self._shape
        return self._memory[LAST : LAST + n].copy() if max(m, n) <= LARGEST_COMPILED else self._remembered.last


def _parts(one: tuple[int, int], other: tuple[int, int]) -> list[tuple[int, int, int]]:
    """Where memories for equations of two shapes have the same: places in both, and how many numbers."""
    (m, n), (rows, joints) = one, other
    count = min(n, joints)
    ends = (LAST + 2 * n, LAST + 2 * joints, min(m, rows))
    return [(0, 0, LAST), (LAST, LAST, count), (LAST + n, LAST + joints, count), ends]


@cache
def _compiled(small: bool) -> Callable[..., bool]:
    """The kernel for at most 8, or else LARGEST_COMPILED, rows and joints."""
    from robust_ik.kernels.second_order import velocity_8, velocity_16

    compiled: Callable[..., bool] = (velocity_8 if small else velocity_16).compiled
    return compiled


def _least(name: str, limits: ArrayLike) -> float:
    found = as_array(limits, name, (), finite=False)
    finite = found[np.isfinite(found)]
    if finite.size == 0 or np.isnan(found).any() or found.min() <= 0:
        raise InputError(f"{name} must be > 0, and one of them finite, got {reprlib.repr(limits)}")
    return float(finite.min())
