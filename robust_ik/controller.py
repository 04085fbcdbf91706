"""One control step: from a task at q to joint velocities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_cap, checked_parameter, readonly
from robust_ik.errors import InputError
from robust_ik.inverses import RobustInverse
from robust_ik.linalg import null_projector
from robust_ik.problem import Resolution
from robust_ik.robot import Robot
from robust_ik.tasks import FrameTask


@dataclass(frozen=True, eq=False)
class Posture:
    """A wish for the joints, met in the null space only: q̇₀ = cap(gain · (target − q)).

    Attributes:
        target: Configuration to drift to, (nq,).
        gain: 1/s.
        max_speed: Cap on every entry of q̇₀, rad/s or m/s.

    Source: J-PARSE, eq. (54) and section VIII-B.
    """

    target: Array
    gain: float = 1.0
    max_speed: float = np.inf

    def __post_init__(self) -> None:
        target = as_array(self.target, "posture target", (None,))
        if target.ndim != 1:
            raise InputError(f"posture target must be one configuration, got shape {target.shape}")
        object.__setattr__(self, "target", readonly(target))
        checked_parameter("posture gain", self.gain, above=0)
        checked_cap("posture max_speed", self.max_speed)

    def qdot(self, robot: Robot, q: ArrayLike) -> Array:
        """Wanted joint velocities, (n,)."""
        return np.clip(self.gain * robot.difference(q, self.target), -self.max_speed, self.max_speed)


@dataclass(frozen=True, eq=False)
class VelocityController:
    """Turns a task into joint velocities: q̇ = J# ẋ + (I − V Vᵀ) q̇₀.

    Attributes:
        robot: The robot.
        inverse: The robust inverse.
        posture: What to do with redundancy, if anything.
        dt: Seconds between steps. An inverse with a memory (`FilteredInverse`, `KelmarKhosla`, `MaciejewskiKlein`) or
            that looks ahead (`Halley`) needs it: one controller is then one run. Without it each step is a first one.
        projector: From J to the projector of the posture's motion, (n, n); that of an ablation, to compare with.
    """

    robot: Robot
    inverse: RobustInverse
    posture: Posture | None = None
    dt: float | None = None
    projector: Callable[[ArrayLike], Array] = null_projector

    def __post_init__(self) -> None:
        if not isinstance(self.robot, Robot):
            raise InputError(f"robot must be a Robot, as rik.load gives it, got {self.robot!r}")
        if not isinstance(self.inverse, RobustInverse):
            raise InputError(f"inverse must be a robust inverse such as JParse(), got {self.inverse!r}")
        if self.dt is not None:
            object.__setattr__(self, "inverse", self.inverse.begin(checked_parameter("dt", self.dt, above=0)))
        if self.posture is not None and self.posture.target.size != self.robot.nq:
            raise InputError(
                f"posture target must have length {self.robot.nq} for {self.robot.name}, got {self.posture.target.size}"
            )

    def step(self, q: ArrayLike, task: FrameTask) -> Resolution:
        """Joint velocities at q.

        Args:
            q: Configuration, (nq,).
            task: What is wanted.
        """
        if np.ndim(q) != 1:
            raise InputError(f"a step takes one configuration, (nq,), got shape {np.shape(q)}")
        equation = task.equation(self.robot, q, hessian=self.inverse.needs_hessian)
        qdot = self.inverse.velocity(equation)
        if self.posture is not None:
            qdot = qdot + self.projector(equation.J) @ self.posture.qdot(self.robot, q)
        return Resolution(qdot=qdot, residual=equation.xdot - equation.J @ qdot)
