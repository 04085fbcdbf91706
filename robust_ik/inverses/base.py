"""The interface of robust inverses, and the promises that each one states.

To add one, see CONTRIBUTING.md: its file here, its name in `inverses/__init__.py` and `__init__.pyi`, its rows in the
contract tables `CASES` of `tests/cases_filters.py` or `OTHER_CASES` of `tests/cases_others.py`.
"""

from __future__ import annotations

import abc
import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, as_number
from robust_ik.errors import InputError
from robust_ik.inverses.damping_formulas import apply_gains
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.svd import SMALLEST_SIGMA, svd


@dataclass(frozen=True)
class Card:
    """The promises of an inverse, in words and symbols, for tables; tests check the numbers behind them.

    Attributes:
        formula: φ(σ), or what is solved.
        largest_gain: Least upper bound of ‖q̇‖/‖ẋ‖.
        gain_at_zero: φ(0⁺), or what happens along a direction that is almost lost. φ(0) itself is 0 for every filter;
            `formula` says so where it would read otherwise.
        exact: Where J q̇ = ẋ.
        continuity: "continuous", or where it jumps.
    """

    formula: str
    largest_gain: str
    gain_at_zero: str
    exact: str
    continuity: str


def _asked_about(function: Callable[..., Any]) -> Callable[..., Any]:
    """The method, with a check that its argument σ₁ is a number ≥ 0."""

    @functools.wraps(function)
    def says(inverse: RobustInverse, sigma_max: float, *others: Any, **named: Any) -> Any:
        given = as_number(sigma_max, "sigma_max")
        if given < 0:
            raise InputError(f"sigma_max must be ≥ 0, got {given:g}")
        return function(inverse, given, *others, **named)

    return says


def _of_spectrum(function: Callable[..., Any]) -> Callable[..., Any]:
    """The method, with a check of its singular values; `.unchecked` skips it for those that come from `svd`."""

    @functools.wraps(function)
    def makes(inverse: RobustInverse, s: ArrayLike) -> Any:
        if type(s) is not np.ndarray or s.dtype != np.float64:
            s = as_array(s, "s", ())
        if s.ndim and s.shape[-1] == 0:
            raise InputError("s must hold at least one singular value, got none")
        if s.size and not (s.min() >= 0 and s.max() < math.inf):
            raise InputError(f"s must be singular values, finite and not negative, got {s}")
        s = np.where(s < SMALLEST_SIGMA, 0.0, s)
        return function(inverse, s) if s.ndim else np.reshape(function(inverse, s[None]), ())

    makes.unchecked = function  # type: ignore[attr-defined]
    return makes


CHECKED = {
    "largest_gain": _asked_about, "gain_at_zero": _asked_about, "jumps": _asked_about,
    "gains": _of_spectrum, "is_exact": _of_spectrum,
}  # fmt: skip
"""Methods that each inverse defines itself, and the check that is put around them."""


class RobustInverse(abc.ABC):
    """Computes joint velocities for a wanted task velocity, which stay moderate near singularities.

    Attributes:
        source: Author, year and equation numbers.
        card: Its promises, for tables.
    """

    source: ClassVar[str]
    card: ClassVar[Card]

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        for name, check in CHECKED.items():
            if name in vars(cls):
                setattr(cls, name, check(vars(cls)[name]))

    @property
    def needs_hessian(self) -> bool:
        """Whether `velocity` reads the equation's Hessian."""
        return False

    @property
    def relative(self) -> bool:
        """Whether its thresholds are fractions of σ₁, so that c J gives 1/c of the joint velocities of J."""
        return False

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

    def largest_gain(self, sigma_max: float) -> float:  # noqa: ARG002
        """‖q̇‖ ≤ largest_gain · ‖ẋ‖ for every J with σ₁ = sigma_max; infinite where no bound is promised."""
        return math.inf

    def velocity(self, equation: TaskEquation) -> Array:
        """Joint velocities for a task; controllers call this method.

        An inverse that needs more than J and ẋ, the task error or the Hessian for example, overrides it; its `solve`
        then says what it assumes instead.

        Args:
            equation: J q̇ = ẋ, with the task error and, where `needs_hessian`, the Hessian.

        Returns:
            q̇, (n,).
        """
        return self.solve(equation.J, equation.xdot)

    def begin(self, dt: float) -> RobustInverse:  # noqa: ARG002
        """The inverse for one run of control steps dt seconds apart: itself, or a new object if it needs a memory.

        The returned object has the memory; the inverse itself stays immutable.
        """
        return self


@dataclass(frozen=True)
class Jump:
    """A discontinuity of the gain along one direction, as its singular value alone changes.

    Where a singular value vanishes and comes back, its pair (u, v) comes back as (u, −v): the signed gain passes from
    −φ(0⁺) to φ(0⁺). So φ(0⁺) ≠ 0 is a jump at σ = 0, and a filter is continuous there only with φ(0⁺) = 0.

    Attributes:
        sigma: The σ where it is.
        height: |φ(σ⁺) − φ(σ⁻)|, and 2|φ(0⁺)| at σ = 0; possibly infinite.
    """

    sigma: float
    height: float


LARGE_SIGMA = 1e100
"""A σ₁ above every absolute threshold, for `continuous`."""


class SingularValueFilter(RobustInverse):
    """An inverse that only rewrites singular values: J# = V diag(φ) Uᵀ.

    Mostly φᵢ = φ(σᵢ), but φᵢ may depend on the whole spectrum, for example on the smallest singular value or on the
    product of all. A singular value that is exactly zero gets φ = 0, since the sign of its (u, v) is arbitrary, and
    with it the motion. So a zero Jacobian gives zero velocity.
    """

    @abc.abstractmethod
    def gains(self, s: ArrayLike) -> Array:
        """φ for a whole spectrum: singular values (..., k) in descending order, k ≥ 1, beginning with σ₁."""

    def gains_of(self, s: Array) -> Array:
        """`gains` of singular values that come from `svd`, without a check: for control loops."""
        gains = type(self).gains
        found: Array = getattr(gains, "unchecked", gains)(self, s)
        return found

    @abc.abstractmethod
    def largest_gain(self, sigma_max: float) -> float:
        """The least upper bound of |φ| over all spectra with σ₁ = sigma_max: ‖q̇‖ ≤ largest_gain · ‖ẋ‖."""

    @abc.abstractmethod
    def is_exact(self, s: ArrayLike) -> np.ndarray:
        """Which directions have σφ = 1, so that the task is met along them, for a whole spectrum; (..., k) of bool."""

    def gain_at_zero(self, sigma_max: float) -> float:  # noqa: ARG002
        """φ(0⁺): joint speed per task speed along one direction that is almost lost, all other σ being σ₁.

        At σ = 0 itself every filter gives 0.
        """
        return 0.0

    def jumps(self, sigma_max: float) -> tuple[Jump, ...]:
        """Every discontinuity while one singular value varies over [0, sigma_max] and the others stay at sigma_max."""
        height = 2 * abs(self.gain_at_zero(sigma_max))
        return (Jump(0.0, height),) if height else ()

    @property
    def continuous(self) -> bool:
        """Whether q̇ is a continuous function of J, rank loss included; at J = 0 unless thresholds are relative."""
        return not self.jumps(LARGE_SIGMA)

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """Joint velocities V diag(φ(σ)) Uᵀ ẋ; see `RobustInverse.solve`."""
        decomposition = svd(J)
        return apply_gains(decomposition, self.gains_of(decomposition.s), xdot)

    def matrix(self, J: ArrayLike) -> Array:
        """The inverse J# itself, (..., n, m)."""
        decomposition = svd(J)
        scaled = decomposition.U * self.gains_of(decomposition.s)[..., None, :]
        return np.asarray(np.swapaxes(scaled @ decomposition.Vt, -1, -2))
