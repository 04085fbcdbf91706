"""The least upper bound of a measure of a filter's gain, found by probing one singular value."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robust_ik.checks import Array, checked_parameter
from robust_ik.errors import InputError
from robust_ik.inverses import SingularValueFilter

DECADES, PER_DECADE = 18, 60
"""The grid over σ: from σ₁ down to 1e-18 σ₁, below all that double precision tells from zero, even in the logarithm."""

REFINEMENTS, PER_REFINEMENT = 6, 41
"""Number of times the best interval is divided, and into how many points.

Each round makes it twenty times narrower. The place of a maximum is then known to 1e-8 of σ, and its value to rounding.
"""

Measure = Callable[[Array, Array], Array]
"""A function of (σ, φ) whose supremum is sought."""


def grid(inverse: SingularValueFilter, sigma_max: float) -> Array:
    """Singular values to probe, ascending, up to σ₁ = sigma_max, with both sides of every declared jump."""
    if not isinstance(inverse, SingularValueFilter):
        raise InputError(f"only a singular-value filter has a gain φ(σ) to probe, got {inverse!r}")
    sigma_max = checked_parameter("sigma_max", sigma_max, above=0)
    jumps = np.array([jump.sigma for jump in inverse.jumps(sigma_max)])
    sides = np.outer([1 - 1e-12, 1, 1 + 1e-12], jumps).ravel()
    s = np.concatenate([sigma_max * np.logspace(-DECADES, 0, DECADES * PER_DECADE + 1), sides])
    return np.unique(s[(s > 0) & (s <= sigma_max)])


def gains_at(inverse: SingularValueFilter, sigma_max: float, sigma: Array) -> Array:
    """φ(σ) of one direction while the other singular value is σ₁ = sigma_max."""
    return inverse.gains(np.stack([np.full_like(sigma, sigma_max), sigma], axis=-1))[..., 1]


def supremum(inverse: SingularValueFilter, sigma_max: float, measure: Measure) -> float:
    """The largest value of measure(σ, φ(σ)) over 0 < σ ≤ sigma_max = σ₁."""
    sigma, best = grid(inverse, sigma_max), -np.inf
    for _ in range(REFINEMENTS):
        values = measure(sigma, gains_at(inverse, sigma_max, sigma))
        i = int(np.argmax(values))
        best = max(best, float(values[i]))
        sigma = np.linspace(sigma[max(i - 1, 0)], sigma[min(i + 1, sigma.size - 1)], PER_REFINEMENT)
    return best
