"""Makes task coordinates of different units and ranges comparable. Arrays only."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array
from robust_ik.checks.public_arguments import computed
from robust_ik.errors import InputError


@computed
def normalise(J: ArrayLike, extents: ArrayLike) -> Array:
    """J with every row divided by the largest value that its task coordinate can take: σ without units, (..., m, n).

    Divide ẋ by the same extents. An upper bound is enough, such as a₁ + a₂ + a₃ for x = a₁ + a₂ c₂ + a₃ c₂₃; the result
    does not depend on the unit of length. If J q̇ = ẋ can be met, the solution does not change; a damped inverse weighs
    the rows by their extents, and lost directions change with them.

    Args:
        J: Jacobian, (..., m, n).
        extents: One positive number per row, (..., m), in the units of the task.

    Source: Duleba 2023, section 6.3, eq. (46).
    """
    J = as_array(J, "J", (None, None))
    extents = as_array(extents, "extents", (J.shape[-2],))
    if not (extents > 0).all():
        raise InputError(f"extents must be > 0, got {extents}")
    return np.asarray(J / extents[..., None])
