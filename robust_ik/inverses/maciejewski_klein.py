"""Numerical filtering without a singular value decomposition per step: the smallest singular values are tracked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, as_measures, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, RobustInverse
from robust_ik.inverses.damped_least_squares import DampedLeastSquares
from robust_ik.inverses.damping_formulas import apply_gains, damped_gain, fading_damping
from robust_ik.inverses.weighted import check_whole
from robust_ik.kinematics.svd import SMALLEST_SIGMA, svd


class SmallestSingularValues:
    """Tracks the d smallest singular values of a slowly moving J and their directions, without an SVD per step.

    Every `update` is one step of subspace iteration: Y = (JJᵀ + δ²I)⁻¹ Û, Û = QR(Y) rotated by Rayleigh-Ritz, and
    σ̂ᵢ = ‖Jᵀûᵢ‖. The first one is an exact decomposition. For m > n the right vectors and JᵀJ are tracked instead.

    The paper has d = 1 and σ̂² = 1/‖y‖ − δ². The quotient ‖Jᵀû‖ costs nothing more and is one iteration ahead.

    Watch for: where the two smallest values cross, d = 1 changes to the other one slowly, by the factor
    (σ_m² + δ²)/(σ_{m−1}² + δ²) per step; it may follow the wrong one for long. Two directions cover every crossing of
    two.

    Attributes:
        directions: d ≥ 1; at most min(m, n) are tracked.
        shift: δ > 0, in the units of σ: keeps JJᵀ + δ²I regular.
        values: σ̂, (..., d) descending: the last one is the smallest. None before the first update.
        vectors: Û, (..., m, d), or the right vectors (..., n, d) where m > n. None before the first update.

    Source: Maciejewski and Klein 1988.
    """

    def __init__(self, directions: int = 2, shift: float = 1e-3) -> None:
        check_whole("directions", directions, 1)
        self.directions, self.shift = directions, checked_parameter("shift", shift, above=0)
        self.values: Array | None = None
        self.vectors: Array | None = None

    def update(self, J: ArrayLike) -> tuple[Array, Array]:
        """The estimates for the next J, (..., m, n): (values, vectors)."""
        wide = _wide(as_array(J, "J", (None, None)))
        if self.vectors is None:
            self.values, self.vectors = _exact(wide, self.directions)
        elif self.vectors.shape[:-1] != wide.shape[:-1]:
            raise InputError(f"J must keep its shape, got {wide.shape} after vectors of shape {self.vectors.shape}")
        else:
            self.values, self.vectors = self._iterate(wide, self.vectors)
        return self.values, self.vectors

    def _iterate(self, J: Array, vectors: Array) -> tuple[Array, Array]:
        gram = J @ np.swapaxes(J, -1, -2)
        basis = np.linalg.qr(np.linalg.solve(_shifted(gram, self.shift), vectors))[0]
        _, rotation = np.linalg.eigh(np.swapaxes(basis, -1, -2) @ gram @ basis)
        vectors = basis @ rotation[..., ::-1]
        return np.linalg.norm(np.swapaxes(J, -1, -2) @ vectors, axis=-2), vectors


@dataclass(frozen=True)
class MaciejewskiKlein(RobustInverse):
    """J^T (J Jᵀ + β²I + Σᵢ λᵢ² ûᵢûᵢᵀ)⁻¹ ẋ: damping along the tracked directions where σ̂ᵢ < ε, and hardly elsewhere.

    λᵢ² = (1 − (σ̂ᵢ/ε)²) λ_max² for each of the smallest singular values, tracked by `SmallestSingularValues`. It has
    a memory: `begin` returns an inverse that tracks; `solve` without it, and the first call of a run, decompose J.

    Watch for: with one direction (the paper) q̇ jumps where the two smallest singular values cross below ε, and only
    β bounds speeds if a second direction is lost; β makes it inexact everywhere, by the fraction β²/(σ² + β²).

    Attributes:
        directions: How many singular values are tracked; 1 is the paper's.
        threshold: ε > 0, in the units of σ.
        damping: λ_max > 0, in the units of σ (squared inside).
        floor: β > 0, in the units of σ (squared inside).
        shift: δ > 0 of the tracking.

    Source: Maciejewski and Klein 1988; Chiaverini 1997, eq. (20); the law of λ: Kim et al., eq. (31) and (32).
    """

    source: ClassVar[str] = "Maciejewski-Klein 1988, Chiaverini 1997"
    card: ClassVar[Card] = Card(
        formula="Jᵀ(JJᵀ + β²I + Σ λᵢ²ûᵢûᵢᵀ)⁻¹, λᵢ² = (1 − (σ̂ᵢ/ε)²) λ_max² below ε",
        largest_gain="1/(2β)",
        gain_at_zero="0",
        exact="nowhere; to β²/σ² while all σ ≥ ε",
        continuity="jumps where the last tracked σ meets the next one below ε",
    )
    directions: int = 2
    threshold: float = 0.05
    damping: float = 0.07
    floor: float = 0.005
    shift: float = 1e-3

    def __post_init__(self) -> None:
        check_whole("directions", self.directions, 1)
        for name in ("threshold", "damping", "floor", "shift"):
            checked_parameter(name, getattr(self, name), above=0)

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """The same filter with the exact singular values; see `RobustInverse.solve`."""
        decomposition = svd(J)
        s = decomposition.s
        squared = fading_damping(s, self.threshold, self.damping)
        squared[..., : -self.directions] = 0.0
        return apply_gains(decomposition, damped_gain(s, squared + self.floor**2), xdot)

    def begin(self, dt: float) -> RobustInverse:  # noqa: ARG002
        """An inverse that tracks the smallest singular values from call to call."""
        return _MaciejewskiKleinRun(self)

    def largest_gain(self, sigma_max: float) -> float:
        """1/(2β), whatever the estimates are; its value at σ₁ while σ₁ < β."""
        return DampedLeastSquares(self.floor).largest_gain(sigma_max)


class _MaciejewskiKleinRun(RobustInverse):
    source: ClassVar[str] = MaciejewskiKlein.source
    card: ClassVar[Card] = MaciejewskiKlein.card

    def __init__(self, inverse: MaciejewskiKlein) -> None:
        self.inverse = inverse
        self._tracked = SmallestSingularValues(inverse.directions, inverse.shift)

    def begin(self, dt: float) -> RobustInverse:
        return self.inverse.begin(dt)

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        J = as_array(J, "J", (None, None))
        xdot = as_measures(xdot, "xdot", (J.shape[-2],))
        values, vectors = self._tracked.update(J)
        wide, transposed = _wide(J), J.shape[-2] > J.shape[-1]
        squared = fading_damping(values, self.inverse.threshold, self.inverse.damping)[..., None, :]
        regular = _shifted(wide @ np.swapaxes(wide, -1, -2), self.inverse.floor)
        regular += (vectors * squared) @ np.swapaxes(vectors, -1, -2)
        if transposed:  # (JᵀJ + …)⁻¹ Jᵀ ẋ
            return np.asarray(np.linalg.solve(regular, wide @ xdot[..., None])[..., 0])
        return np.asarray((np.swapaxes(wide, -1, -2) @ np.linalg.solve(regular, xdot[..., None]))[..., 0])


def _shifted(gram: Array, shift: float) -> Array:
    """JJᵀ + δ²I, with δ² at least so large that it is not lost in the rounding of JJᵀ."""
    least = 1e-14 * np.trace(gram, axis1=-2, axis2=-1)
    return np.asarray(gram + np.maximum(shift**2, least)[..., None, None] * np.eye(gram.shape[-1]))


def _wide(J: Array) -> Array:
    """J, or its transpose if J has more rows than columns; entries too small to square are set to zero."""
    J = np.where(np.abs(J) < SMALLEST_SIGMA, 0.0, J)
    return np.swapaxes(J, -1, -2) if J.shape[-2] > J.shape[-1] else J


def _exact(J: Array, directions: int) -> tuple[Array, Array]:
    decomposition = svd(J)
    return decomposition.s[..., -directions:], decomposition.U[..., -directions:]
