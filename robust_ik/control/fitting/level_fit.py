"""One level's wish, and the two programs that fit it into the bounds: the nearest motion, and the largest share of it.

Both choose by what motions cost, see `motion_cost`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array
from robust_ik.control.bounds import Bounds
from robust_ik.control.fitting.bounded_qp import share_of, solve_within
from robust_ik.control.fitting.motion_cost import MotionCost, motion_cost
from robust_ik.control.fitting.null_space import Freedom, Reduced
from robust_ik.kinematics.svd import complement, length

SHARE_PRICE = 1e-6
"""What makes the program strictly convex in the share: next to nothing."""

HUGE = 1e50
"""Wishes beyond this are taken as this one: their products could overflow."""

TURN = 1e-3
"""How far a motion that keeps its direction may turn at most, as a fraction of the wish in the norm of H."""


@dataclass(frozen=True, eq=False)
class Wish:
    """One level's wish and where it stands.

    Attributes:
        qdot: What higher levels have settled, inside the bounds, (n,).
        motion: What the level's inverse wants on top, (n,), within `freedom`.
        reduced: The level's Jacobian in `freedom`.
        freedom: What higher levels leave.
        bounds: What must be respected.
        stride: Δt ‖ẋ‖: how far the level wants to go in this step, in the units of its rows; 0 where that is not known.
    """

    qdot: Array
    motion: Array
    reduced: Reduced
    freedom: Freedom
    bounds: Bounds
    stride: float = 0.0

    @property
    def cost(self) -> MotionCost:
        """What motions of the level cost."""
        return motion_cost(self.reduced, self.stride)


def slowed(wish: Wish) -> tuple[Array, float]:
    """The motion as much slower as the tightest bound asks, and its share of the wish."""
    share = wish.bounds.largest_step(wish.qdot, wish.motion)
    return share * wish.motion, share


def within_speeds(wish: Wish) -> Array:
    """The motion as much slower as the speed limits alone ask: joints at other bounds do not stop the rest."""
    fastest = wish.bounds.fastest
    if fastest is None:
        return wish.motion
    left = np.maximum(fastest - np.sign(wish.motion) * wish.qdot, 0.0)
    too_fast = np.abs(wish.motion) > left
    share = np.min(left[too_fast] / np.abs(wish.motion[too_fast]), initial=1.0)
    return np.asarray(share * wish.motion)


def nearest(wish: Wish, motion: Array, backend: str | None = None) -> tuple[Array, float]:
    """The motion inside the bounds nearest to a given one, and its share of the wish in the wish's direction."""
    cost = wish.cost
    roots = np.sqrt(cost.weights)
    directions = cost.directions / roots
    wanted = roots * (cost.directions.T @ motion)
    y = solve_within(np.eye(len(roots)), -wanted, directions, wish.bounds, wish.qdot, backend)
    change = directions @ y
    return change, share_of(wish.reduced.matrix @ wish.motion, wish.reduced.matrix @ change)


def directed(wish: Wish, backend: str | None = None) -> tuple[Array, float]:
    """The share of the motion that is worth its help: t q̇ + w + z, where z moves the level nowhere.

    Maximises t q̇ᵀ H q̇ − ½ zᵀ H z − ½ wᵀ H w/TURN² with t ≤ 1, w orthogonal to q̇ in H: all there is where help is cheap,
    and no share that its help is not worth. A turn w of at most TURN of the wish, in the norm of H, makes it continuous
    where a joint at its end begins to be asked to go on, which otherwise would stop all others at once.
    """
    cost = wish.cost
    rank, largest = cost.rank, float(np.abs(wish.motion).max(initial=0.0)) or 1.0  # its squares could overflow
    if largest > HUGE:
        change, share = directed(replace(wish, motion=wish.motion * (HUGE / largest)), backend)
        return change, share * (HUGE / largest)
    roots = np.sqrt(cost.weights)
    moving, resting = cost.directions[:, :rank] / roots[:rank], cost.directions[:, rank:] / roots[rank:]
    wanted = roots[:rank] * (cost.directions[:, :rank].T @ (wish.motion / largest))
    size = length(wanted)
    if size == 0.0:
        return slowed(wish)
    unit = wanted / size
    along = cost.directions[:, :rank] @ (roots[:rank] * unit)  # along · q̇ is what of it the wish's direction has, in H
    capped = replace(  # not further along than wished
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
