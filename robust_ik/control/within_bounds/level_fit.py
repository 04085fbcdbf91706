"""One level's wish, and two programs that fit it into the bounds: for the nearest motion, and for its largest share.

Both use the cost of motions, see `motion_cost`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.bounds import ROUNDING, Bounds
from robust_ik.control.within_bounds.bounded_qp import share_of, solve_within
from robust_ik.control.within_bounds.motion_cost import MotionCost, motion_cost
from robust_ik.control.within_bounds.null_space import Freedom, Reduced
from robust_ik.kinematics.svd import complement, length

SHARE_PRICE = 1e-6
"""A negligible weight that makes the program strictly convex in the share."""

HUGE = 1e50
"""Wishes beyond this are cut to it: their products could overflow."""

TURN = 1e-3
"""Largest turn of a motion that keeps its direction, as a fraction of the wish in the norm of H."""


@dataclass(frozen=True, eq=False)
class Wish:
    """The motion that one level wants, and the room for it.

    Attributes:
        qdot: Joint velocities settled by higher levels, inside the bounds, (n,).
        motion: The motion that the level's inverse wants in addition, (n,), within `freedom`.
        reduced: The level's Jacobian in `freedom`.
        freedom: The motions that higher levels leave free.
        bounds: The bounds.
        stride: Δt ‖ẋ‖: how far the level wants to go in this step, in the units of its rows; 0 if unknown.
        dt: Length of this step, s; 0 if unknown.
    """

    qdot: Array
    motion: Array
    reduced: Reduced
    freedom: Freedom
    bounds: Bounds
    stride: float = 0.0
    dt: float = 0.0

    @property
    def cost(self) -> MotionCost:
        """The cost of motions of the level."""
        return motion_cost(self.reduced, self.stride)


def slowed(wish: Wish) -> tuple[Array, float]:
    """The motion slowed as much as the tightest bound requires, and its share of the wish."""
    share = wish.bounds.largest_step(wish.qdot, wish.motion)
    return share * wish.motion, share


def within_speeds(wish: Wish) -> Array:
    """The motion slowed as much as the speed limits alone require: joints at other bounds do not stop the rest."""
    fastest = wish.bounds.fastest
    if fastest is None:
        return wish.motion
    left = np.maximum(fastest - np.sign(wish.motion) * wish.qdot, 0.0) + ROUNDING
    too_fast = np.abs(wish.motion) > left
    share = np.min(left[too_fast] / np.abs(wish.motion[too_fast]), initial=1.0)
    return np.asarray(share * wish.motion)


def nearest(wish: Wish, motion: Array, backend: str | None = None) -> tuple[Array, float]:
    """The motion inside the bounds nearest to a given one, and its share of the wish along the wish."""
    cost = wish.cost
    roots = np.sqrt(cost.weights)
    directions = cost.directions / roots
    wanted = roots * (cost.directions.T @ motion)
    y = solve_within(np.eye(len(roots)), -wanted, directions, wish.bounds, wish.qdot, backend)
    change = directions @ y
    return change, share_of(wish.reduced.matrix @ wish.motion, wish.reduced.matrix @ change)


def keeping_direction(wish: Wish, backend: str | None = None) -> tuple[Array, float]:
    """The motion t q̇ + w + z: the largest share t of the wish q̇ that is worth its help z; z does not move the level.

    It maximises t q̇ᵀ H q̇ − ½ zᵀ H z − ½ wᵀ H w/TURN² with t ≤ 1 and w orthogonal to q̇ in H: the whole wish if help
    is cheap, and no share that is not worth its help. The turn w, of at most TURN of the wish in the norm of H, makes
    the result continuous at the moment when a joint at its end begins to be asked to go on; without it that joint would
    stop all others at once.
    """
    cost = wish.cost
    rank, largest = cost.rank, float(np.abs(wish.motion).max(initial=0.0)) or 1.0  # squares could overflow without it
    if largest > HUGE:
        change, share = keeping_direction(replace(wish, motion=wish.motion * (HUGE / largest)), backend)
        return change, share * (HUGE / largest)
    roots = np.sqrt(cost.weights)
    moving, resting = cost.directions[:, :rank] / roots[:rank], cost.directions[:, rank:] / roots[rank:]
    wanted = roots[:rank] * (cost.directions[:, :rank].T @ (wish.motion / largest))
    size = length(wanted)
    if size == 0.0:
        return slowed(wish)
    unit = wanted / size
    along = cost.directions[:, :rank] @ (roots[:rank] * unit)  # along · q̇: the part of q̇ along the wish, in H
    capped = replace(  # not further along the wish than wanted
        wish.bounds,
        rows=np.concatenate([wish.bounds.rows, -along[None]]),
        floor=np.append(wish.bounds.floor, -(along @ wish.qdot) - largest * size),
    )
    aid = largest * size * np.column_stack([TURN * moving @ complement(unit[None]), resting])
    directions = np.column_stack([wish.motion, aid])
    hessian = np.diag(np.r_[SHARE_PRICE, np.ones(aid.shape[1])])
    y = solve_within(hessian, -np.eye(len(hessian))[0], directions, capped, wish.qdot, backend)
    share = float(np.clip(y[0], 0.0, 1.0))
    return directions @ y, 1.0 if share > 1 - 1e-12 else share
