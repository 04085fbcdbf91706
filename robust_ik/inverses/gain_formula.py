"""A filter whose φ is a formula, written once for arrays and for compiled code."""

from __future__ import annotations

import abc
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array
from robust_ik.inverses.base import SingularValueFilter
from robust_ik.inverses.damping_formulas import Quantity


class GainFormula(SingularValueFilter):
    """A filter whose φᵢ depends on σᵢ, on σ₁, on the smallest σ, on Π σ and on i.

    `formula` is called with arrays, and `Stepper` compiles it for numbers. So it may use arithmetic, comparisons, `&`,
    `inverses.where` in place of `np.where` and `if`, NumPy's elementwise functions (`np.minimum`, `np.hypot`, ...),
    and plain functions that use only these; no `self`.
    """

    @staticmethod
    @abc.abstractmethod
    def formula(
        s: Quantity, largest: Quantity, smallest: Quantity, product: Quantity, place: Quantity, p: Any
    ) -> Quantity:
        """φ(σ).

        Args:
            s: σ ≥ 0.
            largest: σ₁.
            smallest: The last σ.
            product: Π σ, 0 where the smallest is 0.
            place: How many singular values come after this one.
            p: `parameters`, by their index.
        """

    @property
    @abc.abstractmethod
    def parameters(self) -> tuple[float, ...]:
        """The numbers that `formula` reads."""

    def gains(self, s: ArrayLike) -> Array:
        """φ for a whole spectrum, (..., k); a single number is a spectrum of length one."""
        s = np.asarray(s, dtype=float)
        spectrum = np.atleast_1d(s)
        smallest = spectrum[..., -1:]
        place = np.arange(spectrum.shape[-1])[::-1]
        with np.errstate(over="ignore", invalid="ignore"):  # σ may be beyond any threshold; 0 · ∞ is replaced
            product = np.where(smallest > 0, np.prod(spectrum, axis=-1, keepdims=True), 0.0)
            phi = self.formula(spectrum, spectrum[..., :1], smallest, product, place, self.parameters)
        return np.array(np.broadcast_to(phi, spectrum.shape)).reshape(s.shape)
