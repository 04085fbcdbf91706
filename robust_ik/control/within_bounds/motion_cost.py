"""The cost of a joint motion, by which limiters choose among the motions inside the bounds.

Let q̇* = V diag(φ) Uᵀ ẋ be the motion that a level's filter wants. A limiter takes the motion inside the bounds that is
nearest to it in the metric H = V diag(h) Vᵀ, h = max(σ², floor): nearest in its effect on the task, with a cost on all
unwanted motion. Rest is inside the bounds, so that, with P = U diag(hφ/σ) Uᵀ, which is 1 where the filter is exact and
σ² is over the floor,

    ẋᵀ P J q̇ ≥ q̇ᵀ H q̇:

no joint moves without progress. For every task that feeds its error back, ẋ is minus the gradient of a potential of the
error, and progress makes that potential fall: if P = 1, by at least Δt (q̇ᵀ H q̇ − ½ Δt q̇ᵀ B q̇) in a step, where B is
the curvature of the potential. With H > ½ Δt B it falls until the arm rests, whichever bounds act in whichever step. Of
B, the part Jᵀ J is below H; the rest, ẋ · ∂J along q̇ twice, is below 2 ‖ẋ‖ σ₁ ‖q̇‖² for arms of usual proportions, as
a test shows on a dozen. So the floor is σ₁² PRICE + Δt ‖ẋ‖ σ₁. In general P is not 1, and this is no proof; whole
motions are run and checked instead, see `make soak`.

Without a floor a motion with almost no progress would cost almost nothing: near singularities of the arm without the
joints at their bounds, joints would move back and forth at full speed for a ten-thousandth of the wish.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.within_bounds.null_space import Reduced

PRICE = 1e-3
"""Least cost of a motion, relative to σ₁²: like a damping of √PRICE σ₁ of the arm without the held joints."""


@dataclass(frozen=True, eq=False)
class MotionCost:
    """½ Σᵢ weightᵢ (directionᵢ · q̇)².

    Attributes:
        directions: An orthonormal basis of the level's freedom, (n, d): what moves the level, then what does not.
        weights: H/σ₁² in this basis, (d,), in [PRICE, 1].
        rank: How many directions move the level.
    """

    directions: Array
    weights: Array
    rank: int

    @property
    def floor(self) -> float:
        """The cost of a motion that does not move the level."""
        return float(self.weights[self.rank]) if self.rank < len(self.weights) else PRICE


def motion_cost(reduced: Reduced, stride: float = 0.0) -> MotionCost:
    """The cost of a level's motions.

    Args:
        reduced: The level's Jacobian in the freedom left to it.
        stride: Δt ‖ẋ‖: how far the level wants to go in this step, in the units of its rows.
    """
    rank, largest = reduced.rank, reduced.sigma_max if len(reduced.own) else 0.0
    directions = np.column_stack([reduced.motions.T, reduced.idle])
    if rank == 0 or largest == 0.0:
        return MotionCost(directions, np.ones(directions.shape[1]), 0)
    floor = min(1.0, PRICE + stride / largest)
    squares = np.r_[(reduced.s[:rank] / largest) ** 2, np.zeros(reduced.idle.shape[1])]
    return MotionCost(directions, np.clip(squares, floor, 1.0), rank)
