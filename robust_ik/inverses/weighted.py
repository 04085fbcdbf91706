"""Weights for any inverse: units of the task, cost of the joints."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, as_measures, checked_parameter, readonly
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, RobustInverse
from robust_ik.inverses.task_equation import TaskEquation

SYMMETRY_TOLERANCE = 1e-12
"""Largest asymmetry, relative to the largest entry. Chosen: rounding of products leaves about 1e-15, a mistake more."""
SAMPLES = 65
"""Values of σ₁ at which the bound of the wrapped inverse is evaluated. Chosen: more miss less of a peak between two."""


@dataclass(frozen=True)
class Weighted(RobustInverse):
    """Any inverse in scaled coordinates: J̃ = W_x J W_q^(−½), P = W_q^(−½) P̃ W_x.

    With `MoorePenrose` and joint weights it is the weighted pseudo-inverse W⁻¹Jᵀ(JW⁻¹Jᵀ)⁻¹, which minimises
    q̇ᵀ W_q q̇. With `DampedLeastSquares` it minimises ‖W_x (J q̇ − ẋ)‖² + λ² q̇ᵀ W_q q̇. A length scale L divides the
    linear rows: singular values, thresholds and damping then do not mix metres with radians.

    Watch for: task weights multiply the rows (their squares weigh the errors), joint weights are the cost itself.
    Where the wrapped inverse is exact, task weights change nothing.

    Attributes:
        inverse: The inverse of the scaled Jacobian; its thresholds and damping are in scaled units.
        joint_weights: W_q: (n,) positive, or (n, n) symmetric positive definite; kept as tuples.
        task_weights: W_x: (m,) positive, or (m, m) symmetric positive definite; kept as tuples.
        length_scale: L > 0, m: W_x = diag(1/L for linear rows, 1 for angular ones). Instead of task weights.
        linear_rows: How many of the first rows are linear; without it J must have 6 rows, 3 of them linear.

    Source: Duleba 2023, eq. (45), for the joints; Nakamura 1991 for both.
    """

    source: ClassVar[str] = "Duleba 2023, eq. (45); Nakamura 1991"
    card: ClassVar[Card] = Card(
        formula="W_q^(−½) P̃(W_x J W_q^(−½)) W_x for any inverse P̃",
        largest_gain="g̃ ‖W_q^(−½)‖ ‖W_x‖",
        gain_at_zero="that of the inverse, scaled",
        exact="as the inverse",
        continuity="as the inverse",
    )
    inverse: RobustInverse
    joint_weights: ArrayLike | None = None
    task_weights: ArrayLike | None = None
    length_scale: float | None = None
    linear_rows: int | None = None
    _joint_factor: Array | None = field(init=False, repr=False, compare=False)
    _task_factor: Array | None = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.inverse, RobustInverse):
            raise InputError(f"inverse must be a RobustInverse, got {self.inverse!r}")
        self._keep("joint_weights", "_joint_factor", -0.5)
        self._keep("task_weights", "_task_factor", 1.0)
        if self.length_scale is None:
            if self.linear_rows is not None:
                raise InputError("linear_rows says which rows length_scale divides: give both or neither")
            return
        checked_parameter("length_scale", self.length_scale, above=0)
        if self.task_weights is not None:
            raise InputError("give task_weights or length_scale, not both")
        check_linear_rows(self.linear_rows)

    def _keep(self, name: str, factor: str, power: float) -> None:
        """Stores weights as tuples, so that inverses compare by value, and a power of their matrix."""
        given = getattr(self, name)
        weights = None if given is None else _positive_definite(name, given)
        object.__setattr__(self, name, None if weights is None else _tuples(weights))
        object.__setattr__(self, factor, None if weights is None else readonly(_power(weights, power)))

    @property
    def needs_hessian(self) -> bool:
        """Whether the wrapped inverse reads the Hessian."""
        return self.inverse.needs_hessian

    @property
    def relative(self) -> bool:
        """Whether the wrapped inverse is relative."""
        return self.inverse.relative

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """Joint velocities W_q^(−½) P̃ W_x ẋ; see `RobustInverse.solve`."""
        J = as_array(J, "J", (None, None))
        xdot = as_measures(xdot, "xdot", (J.shape[-2],))
        task, joint = self.factors(*J.shape[-2:])
        return np.asarray(self.inverse.solve(task @ J @ joint, xdot @ task.T) @ joint.T)

    def velocity(self, equation: TaskEquation) -> Array:
        """q̇ by the wrapped inverse from the scaled equation; error and Hessian are scaled alike."""
        task, joint = self.factors(*equation.J.shape[-2:])
        H = equation.hessian
        scaled = TaskEquation(
            J=task @ equation.J @ joint,
            xdot=(task @ np.asarray(equation.xdot)[..., None])[..., 0],
            error=(task @ np.asarray(equation.error)[..., None])[..., 0],
            hessian=None if H is None else np.einsum("ab,...bcd,ci,dj->...aij", task, H, joint, joint, optimize=True),
        )
        return np.asarray((joint @ self.inverse.velocity(scaled)[..., None])[..., 0])

    def begin(self, dt: float) -> RobustInverse:
        """The same weights around the wrapped inverse's object for a run."""
        driver = self.inverse.begin(dt)
        return self if driver is self.inverse else replace(self, inverse=driver)

    def largest_gain(self, sigma_max: float) -> float:
        """A bound: the largest gain of the wrapped inverse over all possible σ̃₁, times ‖W_q^(−½)‖ ‖W_x‖.

        Sampled; exact where the bound of the wrapped inverse is monotone in σ₁, as it mostly is.
        """
        joint, task = _extremes(self._joint_factor), _extremes(self._task_factor)
        if self.length_scale is not None:
            task = (min(1.0, 1 / self.length_scale), max(1.0, 1 / self.length_scale))
        scales = np.geomspace(joint[0] * task[0], joint[1] * task[1], SAMPLES)
        return max(self.inverse.largest_gain(float(sigma_max * scale)) for scale in scales) * joint[1] * task[1]

    def factors(self, m: int, n: int) -> tuple[Array, Array]:
        """W_x, (m, m), and W_q^(−½), (n, n), for a J with m rows and n columns.

        Raises:
            InputError: The weights are for another number of rows or joints.
        """
        task = np.eye(m) if self._task_factor is None else self._task_factor
        joint = np.eye(n) if self._joint_factor is None else self._joint_factor
        if self.length_scale is not None:
            if self.linear_rows is None and m != 6:
                raise InputError(f"length_scale takes 3 of 6 rows as linear; J has {m} rows: say linear_rows")
            linear = leading_rows(self.linear_rows, m)
            task = np.diag(np.repeat([1 / self.length_scale, 1.0], [linear, m - linear]))
        if len(task) != m:
            raise InputError(f"task_weights are for {len(task)} rows, J has {m}")
        if len(joint) != n:
            raise InputError(f"joint_weights are for {len(joint)} joints, J has {n} columns")
        return task, joint


def check_linear_rows(linear_rows: int | None) -> None:
    """Raises unless `linear_rows` is None or a whole number ≥ 0."""
    if linear_rows is not None:
        check_whole("linear_rows", linear_rows, 0)


def check_whole(name: str, value: int, least: int) -> None:
    """Raises unless the value is a whole number ≥ least."""
    if not isinstance(value, (int, np.integer)) or value < least:
        raise InputError(f"{name} must be a whole number ≥ {least}, got {value!r}")


def leading_rows(linear_rows: int | None, m: int) -> int:
    """How many of the first rows of m are linear: `linear_rows` if given, else 3, or m if that is less.

    Raises:
        InputError: `linear_rows` is more than m.
    """
    if linear_rows is None:
        return min(3, m)
    if linear_rows > m:
        raise InputError(f"linear_rows is {linear_rows}, J has only {m} rows")
    return linear_rows


def _positive_definite(name: str, given: ArrayLike) -> Array:
    """The weights, checked: a vector of positive numbers, or a symmetric positive definite matrix."""
    weights = as_array(given, name, (None,))
    if weights.ndim == 1 and weights.size and (weights > 0).all():
        return weights
    if weights.ndim == 2 and weights.size and weights.shape[0] == weights.shape[1]:
        symmetric = np.abs(weights - weights.T).max() <= SYMMETRY_TOLERANCE * np.abs(weights).max()
        if symmetric and np.linalg.eigvalsh(weights)[0] > 0:
            return weights
    raise InputError(f"{name} must be positive, (k,), or a symmetric positive definite matrix, (k, k), got {given!r}")


def _power(weights: Array, power: float) -> Array:
    """W^power as a matrix."""
    if weights.ndim == 1:
        return np.diag(weights**power)
    values, vectors = np.linalg.eigh(weights)
    return np.asarray((vectors * values**power) @ vectors.T)


def _extremes(factor: Array | None) -> tuple[float, float]:
    """The least and the largest eigenvalue of a factor; 1 and 1 for None."""
    if factor is None:
        return 1.0, 1.0
    values = np.linalg.eigvalsh(factor)
    return float(values[0]), float(values[-1])


def _tuples(weights: Array) -> tuple[Any, ...]:
    return tuple(tuple(row) if isinstance(row, list) else row for row in weights.tolist())
