"""The filtered inverse: a matrix that follows the inverse of J at a finite rate, also through singularities."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, as_measures, check_leading_axes, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, RobustInverse, SingularValueFilter
from robust_ik.inverses.damped_least_squares import DampedLeastSquares
from robust_ik.kinematics.svd import svd


@dataclass(frozen=True)
class FilteredInverse(RobustInverse):
    """q̇ = Θẋ with Θ̇ = −Γ (JᵀJΘ + ΘJJᵀ + 2λ²Θ − 2Jᵀ): gradient flow towards ΘJ = I and JΘ = I.

    Along a pair with singular value σ, Θ relaxes to σ/(σ² + λ²) at the rate 2Γ(σ² + λ²); without leakage (λ = 0) it
    does not change along a direction with σ = 0. Each step integrates the flow exactly, with J constant over dt, so no
    Γ·dt is too large.

    It has a memory: `begin` returns an inverse that keeps Θ from call to call. The first call of a run, and `solve`
    without `begin`, use Θ₀.

    Watch for: Θ lags behind J by 1/(2Γσ²) seconds, which is long along weak directions: the task is not met exactly
    while J moves. Only the leakage bounds Θ for all times.

    Attributes:
        rate: Γ > 0, 1/s per σ².
        leakage: λ ≥ 0, in the units of σ; then the steady state is damped least squares.
        initial: The filter that gives Θ₀ = J# of the first J; None starts from Θ₀ = 0.

    Source: Vargas, Leite and Costa 2013 (the flow; the leakage is an option of ours).
    """

    source: ClassVar[str] = "Vargas-Leite-Costa 2013"
    card: ClassVar[Card] = Card(
        formula="q̇ = Θẋ, Θ̇ = −Γ(JᵀJΘ + ΘJJᵀ + 2λ²Θ − 2Jᵀ)",
        largest_gain="none for all times; grows at the most by 2Γσ dt per step",
        gain_at_zero="what Θ holds",
        exact="J at rest, λ = 0, after several 1/(2Γσ²)",
        continuity="continuous; depends on the past",
    )
    rate: float = 20.0
    leakage: float = 0.0
    initial: SingularValueFilter | None = field(default_factory=DampedLeastSquares)

    def __post_init__(self) -> None:
        checked_parameter("rate", self.rate, above=0)
        checked_parameter("leakage", self.leakage, least=0)
        if self.initial is not None and not isinstance(self.initial, SingularValueFilter):
            raise InputError(f"initial must be a SingularValueFilter or None, got {self.initial!r}")

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """The first call of a run, Θ₀ẋ; see `RobustInverse.solve`."""
        return self.begin(1.0).solve(J, xdot)

    def begin(self, dt: float) -> RobustInverse:
        """An inverse that keeps Θ from call to call, dt seconds apart."""
        return _FilteredRun(self, checked_parameter("dt", dt, above=0))

    def start(self, J: ArrayLike) -> Array:
        """Θ₀, (..., n, m)."""
        if self.initial is not None:
            return self.initial.matrix(J)
        return np.zeros_like(np.swapaxes(as_array(J, "J", (None, None)), -1, -2))

    def advance(self, theta: ArrayLike, J: ArrayLike, dt: float) -> Array:
        """Θ after dt seconds at a constant J, exact.

        Args:
            theta: Θ before, (..., n, m).
            J: Jacobian, (..., m, n).
            dt: Seconds, ≥ 0.
        """
        J = as_measures(J, "J", (None, None))
        m, n = J.shape[-2:]
        theta, dt = as_measures(theta, "theta", (n, m)), checked_parameter("dt", dt, least=0)
        # Padded to a square, so that U and V are complete; the padding stays zero.
        size = max(m, n)
        whole = svd(_padded(J, size))
        square = whole.s**2 + self.leakage**2
        rates = self.rate * (square[..., :, None] + square[..., None, :])
        entries = whole.Vt @ _padded(theta, size) @ whole.U * np.exp(-rates * dt)
        # ∫ e^(−r t) dt of the drive 2Γσ on the diagonal; r = 0 comes with σ = 0 only.
        r = 2 * self.rate * square
        decayed = np.where(r > 0, -np.expm1(-r * dt) / np.where(r > 0, r, 1.0), dt)
        diagonal = 2 * self.rate * whole.s * decayed
        entries += diagonal[..., None] * np.eye(size)
        return np.asarray(np.swapaxes(whole.Vt, -1, -2) @ entries @ np.swapaxes(whole.U, -1, -2))[..., :n, :m]


class _FilteredRun(RobustInverse):
    source: ClassVar[str] = FilteredInverse.source
    card: ClassVar[Card] = FilteredInverse.card

    def __init__(self, inverse: FilteredInverse, dt: float) -> None:
        self.inverse, self.dt = inverse, dt
        self._theta: Array | None = None

    def begin(self, dt: float) -> RobustInverse:
        return self.inverse.begin(dt)

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        J = as_array(J, "J", (None, None))
        xdot = as_measures(xdot, "xdot", (J.shape[-2],))
        check_leading_axes("J", J.shape[:-2], "xdot", xdot.shape[:-1])
        shape = np.swapaxes(J, -1, -2).shape
        if self._theta is None:
            theta = self.inverse.start(J)
        elif self._theta.shape == shape:
            theta = self.inverse.advance(self._theta, J, self.dt)
        else:
            raise InputError(f"a run takes J of one shape, got {J.shape} after Θ of shape {self._theta.shape}")
        self._theta = theta
        return np.asarray((theta @ xdot[..., None])[..., 0])


def _padded(matrix: Array, size: int) -> Array:
    padded = np.zeros((*matrix.shape[:-2], size, size))
    padded[..., : matrix.shape[-2], : matrix.shape[-1]] = matrix
    return padded
