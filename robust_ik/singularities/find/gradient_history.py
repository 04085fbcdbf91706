"""The history of one gradient search: how singular values fall and how far the gradient turns. Arrays only.

Source: Almarkhi-Maciejewski, figures 1 to 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_parameter, readonly
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import singular_values
from robust_ik.singularities.find.gradient_search import FOUND, Slope, directions, line_search
from robust_ik.singularities.find.rank_residual import check_corank
from robust_ik.singularities.geometry.screw_chain import ScrewChain


@dataclass(frozen=True, eq=False)
class Descent:
    """Every step of one search.

    Attributes:
        corank: k: σ_{m−k+1} should become zero.
        values: Joint values, (T + 1, n).
        s: Singular values, (T + 1, m).
        gradients: The gradient of each step, which goes against it, (T, n).
    """

    corank: int
    values: Array
    s: Array
    gradients: Array

    def __post_init__(self) -> None:
        for name in ("values", "s", "gradients"):
            object.__setattr__(self, name, readonly(getattr(self, name)))

    def __len__(self) -> int:
        return len(self.gradients)

    @property
    def weakest(self) -> Array:
        """The k smallest singular values, σ_{m−k+1} first, (T + 1, k)."""
        return np.asarray(self.s[:, self.s.shape[1] - self.corank :])

    @property
    def converged(self) -> bool:
        """Whether σ_{m−k+1} fell below the paper's ε of 1e-6."""
        return bool(self.weakest[-1, 0] <= FOUND)

    @property
    def turns(self) -> Array:
        """Angles between the gradients of successive steps, (T − 1,), rad."""
        unit = self.gradients / np.maximum(np.linalg.norm(self.gradients, axis=1, keepdims=True), 1e-300)
        return np.asarray(np.arccos(np.clip(np.sum(unit[1:] * unit[:-1], axis=1), -1.0, 1.0)))


def descend(
    chain: ScrewChain,
    corank: int,
    start: ArrayLike,
    *,
    step: float | None = None,
    rotated: bool = True,
    most: int = 200,
) -> Descent:
    """Follows eq. (11) from a start until σ_{m−k+1} is below ε, no step descends, or `most` steps are made.

    Args:
        chain: What moves the tip.
        corank: k.
        start: Joint values, (n,).
        step: α of eq. (11), the same in every step; by default the best one is searched for in each.
        rotated: Whether clusters are rotated and combined, eqs. (12) to (14); only with the default step.
        most: Most steps.

    Raises:
        InputError: The chain cannot have this corank, or a parameter is out of range.
    """
    check_corank(chain, corank)
    start = as_array(start, "start", (chain.n,))
    if start.ndim != 1:
        raise InputError(f"start must be one configuration of shape ({chain.n},), got {start.shape}")
    if step is not None:
        step = checked_parameter("step", step, above=0)
    here, passed, gradients = start[None].copy(), [start], []
    for _ in range(most):
        slope = Slope.at(chain, here, corank)
        sigma = slope.weakest[:, 0]
        if sigma[0] <= FOUND:
            break
        along = directions(chain, here, slope, rotated=rotated and step is None)
        there = line_search(chain, here, corank, sigma, along)[0] if step is None else here - step * along
        if np.array_equal(there, here):
            break
        here = there
        passed.append(here[0])
        gradients.append(along[0])
    values = np.array(passed)
    s = singular_values(chain.jacobian(values))
    return Descent(corank, values, s, np.array(gradients).reshape(-1, chain.n))
