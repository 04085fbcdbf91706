"""User-defined accuracy: near a singularity one task direction is given up first, so that the others stay accurate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, as_measures, check_leading_axes, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses.base import Card, RobustInverse
from robust_ik.inverses.chiaverini import largest_fading_gain
from robust_ik.inverses.damping_formulas import applied, damped_gain, fading_damping
from robust_ik.kinematics.svd import svd


@dataclass(frozen=True)
class UserDefinedAccuracy(RobustInverse):
    """(W J)# W ẋ with W = I − (1 − w) d dᵀ: near a singularity the direction d only has the weight w.

    * w = 1 − (1 − w_min) √(1 − (σ/ε)²) while the smallest singular value σ of J is below ε, else w = 1.
    * (·)# is damped least squares with λ² = (1 − (σ̃/ε)²) λ_max², σ̃ the smallest singular value of W J.

    Away from singularities it is the pseudo-inverse. The papers take σ from W J of the previous step; here it comes
    from J, so that the result is a function of J alone. For constant weights take
    `Weighted(DampedLeastSquares(), task_weights=…)`.

    Watch for: w falls from 1 like a square root, so joint speeds have a kink at ε. The sacrifice only helps if d has a
    part along the lost direction. d is in the axes and units of the rows of J.

    Attributes:
        sacrificed: The direction d that may be given up: the index of a row, or a vector (m,), kept at length 1.
        least_weight: w_min in (0, 1], its weight on a singularity; 1 is plain variable damping.
        threshold: ε > 0, in the units of σ.
        damping: λ_max > 0, in the units of σ (squared inside).

    Source: Chiaverini, Egeland and Kanestrøm 1991; Chiaverini, Siciliano and Egeland 1994.
    """

    source: ClassVar[str] = "Chiaverini-Egeland-Kanestrøm 1991, Chiaverini-Siciliano-Egeland 1994"
    card: ClassVar[Card] = Card(
        formula="(WJ)# W, W = I − (1 − w(σ)) d dᵀ, (·)# damped with λ(σ̃)",
        largest_gain="1/ε for λ_max ≥ ε/√2, else 1/(2λ_max √(1 − (λ_max/ε)²))",
        gain_at_zero="0",
        exact="everywhere while all σ ≥ ε",
        continuity="continuous",
    )
    sacrificed: int | ArrayLike = -1
    least_weight: float = 0.1
    threshold: float = 0.05
    damping: float = 0.07

    def __post_init__(self) -> None:
        if not isinstance(self.sacrificed, int):
            direction = as_measures(self.sacrificed, "sacrificed", (None,))
            length = float(np.linalg.norm(direction))
            if direction.ndim != 1 or not length > 0:
                raise InputError(f"sacrificed must be a row or one direction, (m,), not zero, got {self.sacrificed!r}")
            # A vector of unit length is kept to the last digit, so that a printed inverse is read back equal.
            unit = direction if abs(length - 1) < 1e-12 else direction / length
            object.__setattr__(self, "sacrificed", tuple(unit.tolist()))
        checked_parameter("least_weight", self.least_weight, above=0)
        if self.least_weight > 1:
            raise InputError(f"least_weight must be > 0 and ≤ 1, got {self.least_weight!r}")
        checked_parameter("threshold", self.threshold, above=0)
        checked_parameter("damping", self.damping, above=0)

    def weight(self, J: ArrayLike) -> Array:
        """The weight w of the sacrificed direction, (...)."""
        relative = fading_damping(svd(J).s[..., -1], self.threshold, 1.0)
        return np.asarray(1 - (1 - self.least_weight) * np.sqrt(relative))

    def solve(self, J: ArrayLike, xdot: ArrayLike) -> Array:
        """Joint velocities (W J)# W ẋ; see `RobustInverse.solve`."""
        J = as_array(J, "J", (None, None))
        xdot = as_measures(xdot, "xdot", (J.shape[-2],))
        check_leading_axes("J", J.shape[:-2], "xdot", xdot.shape[:-1])
        d = self._direction(J.shape[-2])
        W = np.eye(d.size) - (1 - self.weight(J))[..., None, None] * np.outer(d, d)
        decomposition = svd(W @ J)
        squared = fading_damping(decomposition.s[..., -1:], self.threshold, self.damping)
        return applied(decomposition, damped_gain(decomposition.s, squared), (W @ xdot[..., None])[..., 0])

    def _direction(self, m: int) -> Array:
        if not isinstance(self.sacrificed, int):
            return as_array(self.sacrificed, "sacrificed", (m,))
        if not -m <= self.sacrificed < m:
            raise InputError(f"sacrificed must lie in [{-m}, {m - 1}] for {m} rows, got {self.sacrificed}")
        return np.asarray(np.eye(m)[self.sacrificed])

    def largest_gain(self, sigma_max: float) -> float:
        """A bound: that of the fading damping, since W amplifies nothing."""
        return largest_fading_gain(sigma_max, self.threshold, self.damping)
