"""Pieces of formulas, for arrays, and for numbers in compiled code."""

from __future__ import annotations

from typing import Any

import numpy as np

from robust_ik.kernels.compiler.where import where

Quantity = Any
"""An array, or in compiled code a number."""


def kept_or_zero(kept: Quantity, s: Quantity) -> Quantity:
    """1/σ where it is kept, else 0."""
    return where(kept, 1.0 / where(kept, s, 1.0), 0.0)


def damped(s: Quantity, squared_damping: Quantity) -> Quantity:
    """σ/(σ² + λ²), and 0 at σ = 0; exactly 1/σ where λ² = 0. No square can overflow or underflow."""
    length = np.hypot(s, np.sqrt(squared_damping))
    length = where(s > 0, length, 1.0)
    return s / length / length


def fading(s: Quantity, threshold: Quantity, damping: Quantity) -> Quantity:
    """λ²(σ) = (1 − (σ/ε)²) λ_max² below the threshold ε and 0 above.

    Source: Chiaverini, Egeland and Kanestrøm 1991; Kim, Marani, Chung and Yuh, eq. (32).
    """
    ratio = np.minimum(s, threshold) / threshold
    return (1.0 - ratio**2) * damping**2
