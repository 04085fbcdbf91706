"""A level's motion fitted into the bounds by a quadratic program."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.boundary import check_type
from robust_ik.checks import Array
from robust_ik.linalg import length
from robust_ik.resolvers.limiters import Limiter, Scaling, Wish
from robust_ik.resolvers.qp import REGULARISATION, check_backend, share_of, solve_within

HELP = 1e-6
"""Price of a joint motion that helps another one, per s: so low that no help is too dear."""


@dataclass(frozen=True)
class QuadraticProgram(Limiter):
    """The motion inside the bounds whose effect on the level is nearest to that of the filtered one.

    Minimises ‖J N (q̇' − q̇)‖² over the level's freedom, where q̇ is what the level's robust inverse wants: so any
    inverse works inside limits, and where limits do not act, its motion is what comes out. Levels one after another
    make it strict (lexicographic).

    Attributes:
        keep_direction: Ask instead for the largest share of the motion without turning it: the optimum of what
            `Saturation` looks for.
        backend: A solver that qpsolvers knows; "daqp" comes with this package.

    Source: Escande, Mansard, Wieber 2014 (hierarchical quadratic programming), on the filtered task.
    """

    keep_direction: bool = False
    backend: str = "daqp"

    def __post_init__(self) -> None:
        check_backend(self.backend)
        check_type("keep_direction", self.keep_direction, "bool")

    def limit(self, wish: Wish) -> tuple[Array, float]:
        """See `Limiter.limit`."""
        scaled, scale = Scaling().limit(wish)
        if scale == 1:
            return scaled, scale
        return self._directed(wish) if self.keep_direction else self._nearest(wish)

    def _nearest(self, wish: Wish) -> tuple[Array, float]:
        """The motion with the nearest effect, and its share of the wish in the wish's direction."""
        basis, reduced = wish.freedom.basis, wish.reduced
        weights = reduced.s[: reduced.rank] / reduced.s[0] if reduced.rank else np.zeros(0)
        rows = weights[:, None] * (reduced.motions @ basis)
        hessian = rows.T @ rows + REGULARISATION * np.eye(basis.shape[1])
        y = solve_within(hessian, -hessian @ (basis.T @ wish.motion), basis, wish.bounds, wish.qdot, self.backend)
        change = basis @ y
        return change, share_of(reduced.matrix @ wish.motion, reduced.matrix @ change)

    def _directed(self, wish: Wish) -> tuple[Array, float]:
        """The largest share of the motion, with as little help as need be from what moves the level nowhere."""
        task = wish.reduced.motions
        along = task.T @ (task @ wish.motion) if len(task) else wish.motion
        whole = length(along)
        if whole == 0:
            return Scaling().limit(wish)
        along = along / whole
        bounds = wish.bounds
        capped = replace(  # not further along than wished
            bounds,
            rows=np.concatenate([bounds.rows, -along[None]]),
            floor=np.append(bounds.floor, -(along @ wish.qdot) - whole),
        )
        directions = np.column_stack([along, wish.reduced.idle])
        size = directions.shape[1]
        y = solve_within(HELP * np.eye(size), -np.eye(size)[0], directions, capped, wish.qdot, self.backend)
        share = float(np.clip(y[0] / whole, 0.0, 1.0))
        return directions @ y, 1.0 if share > 1 - 1e-12 else share
