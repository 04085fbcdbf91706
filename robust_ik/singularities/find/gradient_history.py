"""The history of one gradient search: how singular values fall and how far the gradient turns. Arrays only.

Source: Almarkhi-Maciejewski, figures 1 to 3.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_measures, checked_parameter, readonly
from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import singular_values
from robust_ik.singularities.find.gradient_search import (
    CLUSTER,
    FOUND,
    STEPS,
    Combination,
    Slope,
    chain_of,
    checked_reading,
    directions,
)
from robust_ik.singularities.find.line_search import LineSearch, least_along
from robust_ik.singularities.find.rank_residual import check_corank
from robust_ik.singularities.geometry.screw_chain import ScrewChain

if TYPE_CHECKING:
    from robust_ik.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class Descent:
    """Every step of one search; `len` of it is T, how many were made.

    Attributes:
        corank: k: σ_{m−k+1} should become zero.
        values: Joint values, rad or m, (T + 1, n).
        s: Singular values, (T + 1, m): without those that are always zero.
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


@checked
def gradient_descent(
    robot: Robot | ScrewChain,
    corank: int,
    start: ArrayLike,
    *,
    step: float | None = None,
    rotated: bool = True,
    cluster: float = CLUSTER,
    combination: Combination = "searched",
    line_search: LineSearch = "grid",
    max_iterations: int = STEPS,
) -> Descent:
    """Every step of one descent of σ_{m−k+1}, until it is below 1e-6 or no step lowers it.

    `gradient_search` makes many at once and keeps their ends.

    Args:
        robot: An arm with a tip; its rows, lengths in metres. Or a `ScrewChain` of it, with rows and a unit of its own.
        corank: k, from 1 to the least of the numbers of rows and joints.
        start: Joint values (`Robot.joint_values`), rad or m, (n,).
        step: α of eq. (11), the same in every step, which then need not lower σ; by default a line search chooses it.
        rotated: Whether clusters are rotated and combined, eqs. (12) to (14); only with the default step.
        cluster: As in `gradient_search`.
        combination: As in `gradient_search`.
        line_search: As in `gradient_search`.
        max_iterations: Most steps.

    Raises:
        TipError: The robot was loaded whole, without a tip.
        InputError: The robot cannot have this corank, or a parameter is out of range.

    Source: Almarkhi-Maciejewski, section 2.2, eq. (11), and figures 1 to 3.
    """
    chain = chain_of(robot)
    check_corank(chain, corank)
    start = as_measures(start, "start", (chain.n,))
    if start.ndim != 1:
        raise InputError(f"start must be one configuration of shape ({chain.n},), got {start.shape}")
    if step is not None:
        step = checked_parameter("step", step, above=0)
    reading = checked_reading(rotated and step is None, cluster, combination, line_search)
    if max_iterations < 1:
        raise InputError(f"max_iterations must be at least 1, got {max_iterations}")
    here, passed, gradients = start[None].copy(), [start], []
    for _ in range(max_iterations):
        slope = Slope.at(chain, here, corank)
        sigma = slope.weakest[:, 0]
        if sigma[0] <= FOUND:
            break
        along = directions(chain, here, slope, reading)
        if step is None:
            there = least_along(chain, here, corank, sigma, along, reading.line_search)[0]
        else:
            there = here - step * along
        if np.array_equal(there, here):
            break
        here = there
        passed.append(here[0])
        gradients.append(along[0])
    values = np.array(passed)
    s = singular_values(chain.jacobian(values))[:, : chain.full_rank]
    return Descent(int(corank), values, s, np.array(gradients).reshape(-1, chain.n))
