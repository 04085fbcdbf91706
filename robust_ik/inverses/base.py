"""What every robust inverse is and what it promises.

To add one:

1. write its file here: a frozen dataclass, derived from `SingularValueFilter` if it only rewrites singular values;
2. export it in `inverses/__init__.py`;
3. add a row to the contract table, `CASES` in `tests/test_inverses_contract.py`.
"""

from __future__ import annotations

import abc
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, check_leading_axes
from robust_ik.linalg import svd
from robust_ik.problem import TaskEquation


@dataclass(frozen=True)
class Card:
    """What an inverse promises, in words and symbols, for tables. Its tests check the numbers behind it.

    Attributes:
        formula: φ(σ), or what is solved.
        largest_gain: Least upper bound of ‖q̇‖/‖ẋ‖.
        gain_at_zero: φ(0⁺), or what happens along a direction that is lost.
        exact: Where J q̇ = ẋ.
        continuity: "continuous", or where it jumps.
    """

    formula: str
    largest_gain: str
    gain_at_zero: str
    exact: str
    continuity: str


class RobustInverse(abc.ABC):
    """A way from a wanted task velocity to joint velocities that stays sane near singularities.

    Attributes:
        source: Author, year and equation numbers.
        card: What it promises, for tables.
        needs_hessian: Whether `velocity` reads the equation's Hessian.
    """

    source: ClassVar[str]
    card: ClassVar[Card]
    needs_hessian: ClassVar[bool] = False

    @abc.abstractmethod
    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """Joint velocities for a task velocity.

        Args:
            J: Jacobian, (..., m, n).
            xdot: Task velocity, (..., m); leading axes broadcast against those of J.

        Returns:
            q̇, (..., n).

        Raises:
            InputError: Shapes do not fit, or something is NaN or infinite.
        """

    def velocity(self, equation: TaskEquation) -> Array:
        """Joint velocities for a task: what a controller calls.

        An inverse that looks at more than J and ẋ, such as the task error or the Hessian, overrides it; then `solve`
        says what it assumes in their place.

        Args:
            equation: J q̇ = ẋ, with the task error and, where `needs_hessian`, the Hessian.

        Returns:
            q̇, (n,).
        """
        return self.solve(equation.J, equation.xdot)

    def begin(self, dt: float) -> RobustInverse:  # noqa: ARG002
        """What drives one run of control steps dt seconds apart: itself, or for an inverse with a memory a new one.

        The memory is in what this returns, never in the inverse, which stays a value.
        """
        return self


@dataclass(frozen=True)
class Jump:
    """A place where φ is discontinuous, relative to σ₁ = sigma_max of the call that asked.

    Attributes:
        sigma: Where; at σ = 0 the jump is seen when a signed singular value passes through zero.
        height: |φ(σ⁺) − φ(σ⁻)|, possibly infinite.
    """

    sigma: float
    height: float


class SingularValueFilter(RobustInverse):
    """An inverse that only rewrites singular values: J# = V diag(φ(σ)) Uᵀ."""

    @abc.abstractmethod
    def gains(self, s: ArrayLike) -> Array:
        """φ(σ) for singular values (..., k) in descending order; the first one is σ₁, always given."""

    @abc.abstractmethod
    def largest_gain(self, sigma_max: float) -> float:
        """The least upper bound of φ over 0 ≤ σ ≤ sigma_max = σ₁: ‖q̇‖ ≤ largest_gain · ‖ẋ‖."""

    @abc.abstractmethod
    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """Where σφ(σ) = 1, so that the task is met along that direction, (..., k) of bool."""

    def jumps(self, sigma_max: float) -> tuple[Jump, ...]:  # noqa: ARG002
        """Every discontinuity of φ for σ₁ = sigma_max; empty for a continuous inverse."""
        return ()

    @property
    def continuous(self) -> bool:
        """Whether q̇ is a continuous function of J everywhere, rank loss included."""
        return not self.jumps(1.0)

    def gain_at_zero(self, sigma_max: float) -> float:
        """φ(0⁺): the speed per task speed commanded along a direction that is almost lost."""
        if sigma_max <= 0:
            return 0.0
        return float(self.gains(np.array([sigma_max, 1e-150 * sigma_max]))[1])

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """Joint velocities V diag(φ(σ)) Uᵀ ẋ; see `RobustInverse.solve`."""
        decomposition = svd(J)
        xdot = as_array(xdot, "xdot", (decomposition.U.shape[-2],))
        check_leading_axes("J", decomposition.s.shape[:-1], "xdot", xdot.shape[:-1])
        components = np.einsum("...mk,...m->...k", decomposition.U, xdot)
        return np.asarray(np.einsum("...kn,...k->...n", decomposition.Vt, self.gains(decomposition.s) * components))

    def matrix(self, J: ArrayLike) -> Array:
        """The inverse J# itself, (..., n, m)."""
        decomposition = svd(J)
        scaled = decomposition.U * self.gains(decomposition.s)[..., None, :]
        return np.asarray(np.swapaxes(scaled @ decomposition.Vt, -1, -2))
