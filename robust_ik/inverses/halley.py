"""A second-order step: the curvature that the first-order step neglects is added to the Jacobian."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, RobustInverse, SingularValueFilter
from robust_ik.inverses.jparse import JParse
from robust_ik.inverses.task_equation import TaskEquation


@dataclass(frozen=True)
class Halley(RobustInverse):
    """q̇ = A# ẋ with A = J + ½ Σ_k (∂J/∂q_k) d_k, where d = J# Δx is the first-order step for the wanted step Δx.

    Δx is the whole task error, so that a full step (gain · dt = 1) converges cubically where Newton's does
    quadratically. Inside a run (`begin`) Δx = ẋ dt is what one time step asks for: the path is then followed to second
    order in dt, and with gain · dt = 1 nothing changes.

    `solve` has no Hessian: it is the first-order step J# ẋ.

    Watch for: exact only where the filter is: a constant damping turns the convergence into a linear one. At a
    singular J an unfiltered first step is as large as Newton's. Cap the error (0.33 arm lengths, 1 rad) before the
    step: far from the goal the second-order term is no better than the first.

    Attributes:
        inverse: The filter # for both steps.
        horizon: Seconds of ẋ to look ahead; None for the whole error. `begin` sets it to the time step.

    Source: Lloyd, Irani and Ahmadi 2022 (QuIK).
    """

    source: ClassVar[str] = "Lloyd-Irani-Ahmadi 2022 (QuIK)"
    card: ClassVar[Card] = Card(
        formula="A# ẋ, A = J + ½ Σ_k (∂J/∂q_k) (J# Δx)_k",
        largest_gain="that of the filter, at σ₁ of A",
        gain_at_zero="that of the filter",
        exact="where the filter is, to second order",
        continuity="as the filter",
    )
    inverse: SingularValueFilter = field(default_factory=lambda: JParse(gamma=0.01))
    horizon: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.inverse, SingularValueFilter):
            raise InputError(f"inverse must be a SingularValueFilter, got {self.inverse!r}")
        if self.horizon is not None:
            checked_parameter("horizon", self.horizon, above=0)

    @property
    def needs_hessian(self) -> bool:
        """Yes."""
        return True

    @property
    def relative(self) -> bool:
        """Whether the filter is relative."""
        return self.inverse.relative

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """The first-order step J# ẋ; see `RobustInverse.solve`."""
        return self.inverse.solve(J, xdot)

    def velocity(self, equation: TaskEquation) -> Array:
        """q̇ for ẋ, with J corrected along the first-order step.

        Raises:
            InputError: The equation has no Hessian.
        """
        if equation.hessian is None:
            raise InputError("Halley needs the Hessian ∂J/∂q of the task, the equation has none")
        m, n = equation.J.shape[-2:]
        H = as_array(equation.hessian, "hessian", (m, n, n))
        wanted = equation.error if self.horizon is None else self.horizon * np.asarray(equation.xdot)
        bent = equation.J + 0.5 * np.einsum("...ijk,...k->...ij", H, self.inverse.solve(equation.J, wanted))
        return self.inverse.solve(bent, equation.xdot)

    def begin(self, dt: float) -> RobustInverse:
        """The same inverse with dt as the horizon."""
        return replace(self, horizon=dt)
