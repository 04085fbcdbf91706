"""A level's motion fitted into the bounds by a quadratic program."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.boundary import check_type
from robust_ik.checks import Array
from robust_ik.linalg import complement, length
from robust_ik.resolvers.limiters import Limiter, Scaling, Wish
from robust_ik.resolvers.qp import check_backend, share_of, solve_within

SHARE_PRICE = 1e-6
"""What makes the program strictly convex in the share: next to nothing."""

HUGE = 1e50
"""Wishes beyond this are taken as this one: their products could overflow."""


TURN = 1e-3
"""How far a motion that keeps its direction may turn at most, as a fraction of the wish."""


@dataclass(frozen=True)
class QuadraticProgram(Limiter):
    """The motion inside the bounds that is nearest to the filtered one, in the metric of `motion_cost`.

    Minimises ½ (q̇' − q̇)ᵀ H (q̇' − q̇) over the level's freedom, where q̇ is what the level's robust inverse wants: so
    any inverse works inside limits, and where limits do not act, its motion is what comes out. H weighs what the level
    gets, and prices all motion: that keeps the loop calm, and costs the level about a thousandth of its wish where
    other joints could take over in full. Levels one after another make it strict (lexicographic).

    Attributes:
        keep_direction: Ask instead for the largest share of the motion without turning it, as `Saturation` does.
        backend: A solver that qpsolvers knows; "daqp" comes with this package.

    Source: Escande, Mansard, Wieber 2014 (hierarchical quadratic programming), on the filtered task.
    """

    keep_direction: bool = False
    backend: str = "daqp"

    def __post_init__(self) -> None:
        check_backend(self.backend)
        check_type("keep_direction", self.keep_direction, "bool")

    @property
    def stops(self) -> bool:
        """Where it keeps the direction."""
        return self.keep_direction

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        scaled, scale = Scaling().limit(wish)
        if scale == 1:
            return scaled, scale
        return directed(wish, self.backend) if self.keep_direction else nearest(wish, wish.motion, self.backend)


@dataclass(frozen=True)
class Saturation(Limiter):
    """Saturation in the null space: joints at their bounds stay there, and the level's other joints take over.

    The direction is kept, but for at most TURN of the wish. Where joints run out, or where their help would cost more
    motion than the progress is worth, the level is slowed. It is the optimum of saturating joint after joint, with a
    price on help: a primal active-set method without a solver's overhead, a few passes with a small QR factorisation
    each.

    Source: Flacco, De Luca, Khatib 2015 (SNS), with rows of any kind as bounds and the level's filtered motion as task.
    """

    @property
    def stops(self) -> bool:
        """Yes."""
        return True

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        scaled, scale = Scaling().limit(wish)
        return (scaled, scale) if scale == 1 else directed(wish)


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
        return Scaling().limit(wish)
    unit = wanted / size
    along = cost.directions[:, :rank] @ (roots[:rank] * unit)  # along · q̇ is what of it the wish's direction has, in H
    capped = replace(  # not further along than wished
        wish.bounds,
        rows=np.concatenate([wish.bounds.rows, -along[None]]),
        floor=np.append(wish.bounds.floor, -(along @ wish.qdot) - largest * size),
    )
    help_ = largest * size * np.column_stack([TURN * moving @ complement(unit[None]), resting])
    directions = np.column_stack([wish.motion, help_])
    hessian = np.diag(np.r_[SHARE_PRICE, np.ones(help_.shape[1])])
    y = solve_within(hessian, -np.eye(len(hessian))[0], directions, capped, wish.qdot, backend)
    share = float(np.clip(y[0], 0.0, 1.0))
    return directions @ y, 1.0 if share > 1 - 1e-12 else share
