"""The motion of a level by its robust inverse, also at algorithmic singularities."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import LARGEST_PARAMETER, Array
from robust_ik.control.within_bounds.null_space import Freedom, Reduced
from robust_ik.inverses import RobustInverse, SingularValueFilter, Weighted
from robust_ik.inverses.task_equation import TaskEquation
from robust_ik.kinematics.svd import singular_values


def filtered_motion(
    inverse: RobustInverse, reduced: Reduced, equation: TaskEquation, wanted: Array, freedom: Freedom
) -> Array:
    """(J N)# wanted, (n,).

    Thresholds relative to σ₁ refer to σ₁ of J, not of J N: if a level is about to lose its whole freedom, all singular
    values of J N are small, and none is small relative to the others.

    Args:
        inverse: The robust inverse #.
        reduced: J N.
        equation: The level's equation, for its error and Hessian.
        wanted: Task velocity, (m,). If it compensates motions of levels above, it may be larger than any input may be;
            then its direction is kept.
        freedom: The subspace of N.
    """
    if reduced.rank == 0:
        return np.zeros(equation.J.shape[1])
    if (largest := float(np.abs(wanted).max(initial=0.0))) > LARGEST_PARAMETER:
        wanted = wanted * (LARGEST_PARAMETER / largest)
    kind = type(inverse)
    if kind.velocity is SingularValueFilter.velocity and kind.solve is SingularValueFilter.solve:
        return (wanted @ reduced.U * level_gains(inverse, reduced)) @ reduced.Vt  # already decomposed
    whole = freedom.basis.shape[1] == equation.J.shape[1]
    left, hessian = equation.J if whole else reduced.matrix, equation.hessian
    if not whole and inverse.needs_hessian and hessian is not None:
        N = freedom.basis @ freedom.basis.T
        hessian = np.einsum("ijk,ja,kb->iab", hessian, N, N, optimize=True)
    if inverse.relative and reduced.s[0] < reduced.sigma_max * (1 - 1e-12):
        inverse = _relative_to(equation.J, inverse)
    return _velocity(inverse, TaskEquation(left, wanted, equation.error, hessian))


def _velocity(inverse: RobustInverse, equation: TaskEquation) -> Array:
    """The velocity of the inverse; of first order if it could use a Hessian and the task has none."""
    if inverse.needs_hessian and equation.hessian is None:
        return inverse.solve(equation.J, equation.xdot)
    return inverse.velocity(equation)


def _relative_to(J: Array, inverse: RobustInverse) -> RobustInverse:
    """The inverse with its thresholds relative to σ₁ of J, for any matrix; in scaled coordinates, of the scaled J."""
    if isinstance(inverse, Weighted):
        task, joint = inverse.factors(*J.shape[-2:])
        return replace(inverse, inverse=_relative_to(task @ J @ joint, inverse.inverse))
    return _Beside(inverse, float(singular_values(J)[0]))


@dataclass(frozen=True)
class _Beside(RobustInverse):
    """An inverse that adds a joint and a row with singular value `sigma`, of which no motion is wanted."""

    source: ClassVar[str] = "none: a help"
    inverse: RobustInverse
    sigma: float

    @property
    def needs_hessian(self) -> bool:
        return self.inverse.needs_hessian

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        J, xdot = np.asarray(J), np.asarray(xdot)
        return self.velocity(TaskEquation(J, xdot, np.zeros_like(xdot)))

    def velocity(self, equation: TaskEquation) -> Array:
        J, hessian = equation.J, equation.hessian
        m, n = J.shape
        wider = np.zeros((m + 1, n + 1))
        wider[:m, :n], wider[m, n] = J, self.sigma
        if hessian is not None:
            hessian = np.pad(hessian, ((0, 1), (0, 1), (0, 1)))
        beside = TaskEquation(wider, np.append(equation.xdot, 0.0), np.append(equation.error, 0.0), hessian)
        return _velocity(self.inverse, beside)[:n]


def level_gains(inverse: RobustInverse, reduced: Reduced) -> Array:
    """φ(σ) of a filter for J N, (k,), 0 for σ = 0; thresholds refer to σ₁ of J, as in `filtered_motion`."""
    if reduced.rank == 0 or not isinstance(inverse, SingularValueFilter):
        return np.zeros(len(reduced.s))
    beside = inverse.relative and reduced.s[0] < reduced.sigma_max * (1 - 1e-12)
    gains = inverse.gains_of(np.r_[reduced.sigma_max, reduced.s])[1:] if beside else inverse.gains_of(reduced.s)
    return np.where(reduced.s > 0, gains, 0.0)
