"""Newton's iteration to a configuration that reaches a target, with a robust inverse in place of J⁻¹. Arrays only."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, alone, as_array, checked_parameter, readonly
from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError
from robust_ik.inverses import RobustInverse
from robust_ik.inverses.task_equation import TaskEquation

Function = Callable[[Array], ArrayLike]


class NewtonStatus(Enum):
    """How an iteration ended; the value is the explanation."""

    CONVERGED = "the error fell below the tolerance"
    STUCK = "the inverse gives no motion although the error is not zero: what is left lies along directions it cuts"
    ITERATION_LIMIT = "the error is still above the tolerance after the largest number of iterations"
    DIVERGED = "the configuration grew beyond what a number can hold"


@dataclass(frozen=True, eq=False)
class NewtonResult:
    """Path and end of an iteration.

    Attributes:
        path: The configuration before every step and at the end, (iterations + 1, nq).
        status: How it ended.
        errors: ‖x_f − k(q)‖ at each configuration of the path, (iterations + 1,).
    """

    path: Array
    status: NewtonStatus
    errors: Array

    @property
    def q(self) -> Array:
        """The last configuration, (nq,)."""
        return np.asarray(self.path[-1])

    @property
    def converged(self) -> bool:
        """Whether the error fell below the tolerance."""
        return self.status is NewtonStatus.CONVERGED

    @property
    def iterations(self) -> int:
        """How many steps were taken."""
        return int(self.errors.size) - 1

    @property
    def error(self) -> float:
        """The last error."""
        return float(self.errors[-1])


@checked
def newton(
    kinematics: Function,
    jacobian: Function,
    inverse: RobustInverse,
    q0: ArrayLike,
    target: ArrayLike,
    *,
    step: float = 1.0,
    tolerance: float = 1e-9,
    max_iterations: int = 2000,
    hessian: Function | None = None,
    integrate: Callable[[Array, Array], Array] = np.add,
) -> NewtonResult:
    """Iterates q ← q + ξ J# (x_f − k(q)) until ‖x_f − k(q)‖ < tolerance.

    Poses cannot be subtracted: for them let `kinematics` return minus the pose error, and let the target be zero.

    Watch for: towards a target on the boundary of what the arm reaches, where J loses rank, convergence is slow: the
    error of a damped inverse falls as 1/iterations, so the final error depends on the cap, not on the inverse.

    Args:
        kinematics: Function from q to the task coordinates k(q), (m,).
        jacobian: Function from q to ∂k/∂q, (m, n).
        inverse: The robust inverse; it gets the error, and a time step of `step` seconds.
        q0: Start configuration, (nq,).
        target: Wanted task coordinates x_f, (m,).
        step: ξ in (0, 1].
        tolerance: δ > 0, in the units of the task.
        max_iterations: Cap, at least 0; the paper has none, but without one a run that does not converge would not end.
        hessian: Function from q to ∂J/∂q, (m, n, n), for an inverse that needs it.
        integrate: Adds a joint motion, (n,), to a configuration, (nq,): `robot.integrate` if nq ≠ n.

    Raises:
        InputError: An argument is not valid, or a function returns another shape or NaN.

    Source: Duleba 2023, eq. (3).
    """
    q = _vector(q0, "q0", None)
    target = _vector(target, "target", None)
    step = checked_parameter("step", step, above=0)
    tolerance = checked_parameter("tolerance", tolerance, above=0)
    if step > 1 or max_iterations < 0:
        raise InputError(f"step ≤ 1 and max_iterations ≥ 0 must hold, got {step!r} and {max_iterations!r}")
    if inverse.needs_hessian and hessian is None:
        raise InputError(f"{inverse!r} needs the Hessian: pass hessian=")
    driver = inverse.begin(step)
    errors: list[float] = []
    path = [q.copy()]
    status: NewtonStatus | None = None
    while status is None:
        reached = _vector(kinematics(q), "kinematics(q)", target.size)
        with np.errstate(over="ignore"):  # an overflow is infinite, and does not converge
            error = target - reached
            errors.append(float(np.linalg.norm(error)))
        status = _ended(errors, tolerance, max_iterations)
        if status is None:
            equation = _equation(jacobian, hessian, q, error)
            with np.errstate(over="ignore", invalid="ignore"):
                moved = integrate(q, step * driver.velocity(equation))
            moved = alone(as_array(moved, "integrate(q, dq)", q.shape, finite=False), "integrate(q, dq)", 1)
            # An inverse with a memory may move again after a step of zero.
            status = _stopped(q, moved, repeats=driver is inverse)
            if status is None:
                q = moved
                path.append(q)
    return NewtonResult(readonly(path), status, readonly(errors))


def _equation(jacobian: Function, hessian: Function | None, q: Array, error: Array) -> TaskEquation:
    J = alone(as_array(jacobian(q), "jacobian(q)", (error.size, None)), "jacobian(q)", 2)
    H = None if hessian is None else as_array(hessian(q), "hessian(q)", (*J.shape, J.shape[1]))
    return TaskEquation(J, error, error, H)


def _ended(errors: list[float], tolerance: float, max_iterations: int) -> NewtonStatus | None:
    if errors[-1] < tolerance:
        return NewtonStatus.CONVERGED
    return NewtonStatus.ITERATION_LIMIT if len(errors) > max_iterations else None


def _stopped(q: Array, moved: Array, *, repeats: bool) -> NewtonStatus | None:
    if not np.isfinite(moved).all():
        return NewtonStatus.DIVERGED
    return NewtonStatus.STUCK if repeats and np.array_equal(q, moved) else None


def _vector(value: ArrayLike, name: str, length: int | None) -> Array:
    return alone(as_array(value, name, (length,)), name, 1)
