"""LiveState: all that the page says of one configuration. Numbers from the robot; nothing is computed in the page."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from robust_ik.analysis.explanation import direction_in_words
from robust_ik.checks import Array
from robust_ik.inverses import RobustInverse, SingularValueFilter
from robust_ik.kinematics.rotation_vectors import rotation_vector
from robust_ik.kinematics.svd import RANK_TOLERANCE, svd
from robust_ik.robot.robot import Robot

HALVINGS = 40
"""Halvings of the interval in which a threshold is looked for. Derivation: 2⁻⁴⁰ is 1e-12, of σ₁."""

WHOLE = 0.995
"""Share of a commanded speed from which a direction is not said to be slowed down. Chosen: it is shown as 100 %."""


@dataclass(frozen=True, eq=False)
class LiveState:
    """What a page shows of a robot at one configuration.

    Attributes:
        q: Configuration, (nq,).
        values: Joint values, rad or m, (n,).
        room: Distance of each joint to its nearer limit, as a fraction of half its range; 1 without limits, (n,).
        position: Of the tool in the world, m, (3,).
        rotation: Of the tool, as axis times angle, rad, (3,).
        sigma: Singular values of the Jacobian in the robot's rows, (k,).
        shares: σ φ(σ) of the inverse: the share of a commanded speed that it makes; None if it is no filter, (k,).
        threshold: σ down to which the inverse is exact; None if it is no filter, or nowhere exact.
        manipulability: Πσ.
        condition: σ₁/σ_k; infinite where rank is lost.
        corank: How many of the rows, at most as many as there are joints, no joint moves.
        weak: For each direction that the inverse slows down or that is lost, σ and the direction in words.
        still: How many independent joint motions leave the tool where it is.
    """

    q: Array
    values: Array
    room: Array
    position: Array
    rotation: Array
    sigma: Array
    shares: Array | None
    threshold: float | None
    manipulability: float
    condition: float
    corank: int
    weak: tuple[tuple[float, str], ...]
    still: int

    @classmethod
    def of(cls, robot: Robot, q: Array, inverse: RobustInverse) -> LiveState:
        """The state of a robot with a tip at a configuration (nq,), told for an inverse."""
        T, found = robot.pose(q), svd(robot.jacobian(q))
        s = found.s
        values = robot.joint_values(q)
        told = inverse if isinstance(inverse, SingularValueFilter) and s[0] > 0 else None
        rank = int((s > RANK_TOLERANCE * s[0]).sum())
        shares = None if told is None else told.gains(s) * s
        slow = [place for place in range(len(s)) if place >= rank or (shares is not None and shares[place] < WHOLE)]
        return cls(
            q=q,
            values=values,
            room=room(robot, values),
            position=T[:3, 3],
            rotation=rotation_vector(T[:3, :3]),
            sigma=s,
            shares=shares,
            threshold=None if told is None else threshold(told, float(s[0])),
            manipulability=float(np.prod(s)),
            condition=math.inf if rank < len(s) else float(s[0] / s[-1]),
            corank=len(s) - rank,
            weak=tuple((float(s[place]), direction_in_words(found.U[:, place], robot.rows)) for place in slow),
            still=robot.n - rank,
        )

    def plain(self) -> dict[str, Any]:
        """Its values as JSON has them; what is infinite is null."""
        return {
            "q": self.q.tolist(),
            "values": self.values.tolist(),
            "room": self.room.tolist(),
            "position": self.position.tolist(),
            "rotation": self.rotation.tolist(),
            "sigma": self.sigma.tolist(),
            "shares": None if self.shares is None else self.shares.tolist(),
            "threshold": self.threshold,
            "manipulability": self.manipulability,
            "condition": self.condition if math.isfinite(self.condition) else None,
            "corank": self.corank,
            "weak": [[sigma, words] for sigma, words in self.weak],
            "still": self.still,
        }


def room(robot: Robot, values: Array) -> Array:
    """The distance of each joint to its nearer limit, as a fraction of half its range: (n,) → (n,).

    It is 1 in the middle and without limits, 0 at a limit, negative beyond.
    """
    finite = np.isfinite(robot.lower) & np.isfinite(robot.upper) & (robot.upper > robot.lower)
    lower, upper = np.where(finite, robot.lower, -1.0), np.where(finite, robot.upper, 1.0)
    nearer = np.minimum(values - lower, upper - values) / ((upper - lower) / 2)
    return np.where(finite, nearer, 1.0)


def threshold(inverse: SingularValueFilter, largest: float) -> float | None:
    """σ down to which a filter is exact for a spectrum of two, (σ₁, σ); None if it is not exact at σ₁.

    Args:
        inverse: The filter.
        largest: σ₁ > 0.

    Returns:
        The threshold; 0 if it is below 1e-12 σ₁.
    """

    def exact(sigma: float) -> bool:
        return bool(inverse.is_exact(np.array([largest, sigma]))[1])

    low, high = 0.0, largest
    if not exact(high):
        return None
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if exact(middle) else (middle, high)
    return high if high > largest * 2.0 ** (1 - HALVINGS) else 0.0
