"""Unequal gains for position and orientation along a singular direction: when they are safe.

The gain matrix from error to task velocity, I − uuᵀ + d uuᵀK_s, is not symmetric then; ½‖e‖² falls for every e as long
as its symmetric part has no negative eigenvalue.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.analysis.stability.feedback_gains import positive_gain
from robust_ik.checks import Array, as_array, checked_parameter
from robust_ik.checks.public_arguments import computed
from robust_ik.errors import InputError


@computed
def block_gains_are_stable(position_gain: float, orientation_gain: float, share: float = 1.0) -> bool:
    """Whether √share |√k_p − √k_o| ≤ 2, so that unequal gains along one singular direction cannot feed the error.

    With K_s = diag(k_p I, k_o I) acting on the singular part only, I − uuᵀ + d uuᵀK_s has a positive semidefinite
    symmetric part for every u and every d ≤ share if and only if this holds.

    Watch for: it is a rule for corank 1. With two singular directions of unequal d no unequal gains are safe in this
    sense: for u₁, u₂ in the plane of two rows, d₁ = 1 and d₂ → 0 the determinant tends to −b²/4.

    Args:
        position_gain: k_p > 0.
        orientation_gain: k_o > 0.
        share: The largest d = σφ(σ) of a singular direction: p for J-PARSE.

    Source: J-PARSE, section VII-B; the rule is ours.
    """
    k_p = checked_parameter("position_gain", position_gain, above=0)
    k_o = checked_parameter("orientation_gain", orientation_gain, above=0)
    return bool(checked_parameter("share", share, above=0) * (np.sqrt(k_p) - np.sqrt(k_o)) ** 2 <= 4 * (1 + 1e-12))


@computed
def smallest_eigenvalue_along(u: ArrayLike, gains: ArrayLike, share: float = 1.0) -> Array:
    """The smallest eigenvalue of the symmetric part of I − uuᵀ + d uuᵀK_s, shape (...); the error can grow below 0.

    With a = uᵀK_s u and b = ‖K_s u − a u‖ it is negative if and only if d b² > 4a.

    Args:
        u: The singular task direction, (..., m); its length does not matter.
        gains: The diagonal of K_s, (m,), > 0.
        share: d = σφ(σ) of that direction.
    """
    direction = as_array(u, "u", (None,))
    length = np.linalg.norm(direction, axis=-1, keepdims=True)
    if (length == 0).any():
        raise InputError("u must not be zero")
    unit = direction / length
    fed = checked_parameter("share", share, least=0) * positive_gain(gains, unit.shape[-1]) * unit
    matrix = np.eye(unit.shape[-1]) + unit[..., :, None] * (fed - unit)[..., None, :]
    return np.asarray(np.linalg.eigvalsh((matrix + np.swapaxes(matrix, -1, -2)) / 2)[..., 0])
