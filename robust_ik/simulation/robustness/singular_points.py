"""Singular configurations of an arm to test on, from the families of an atlas, with what is lost there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from robust_ik.checks import Array
from robust_ik.inverses import Exit
from robust_ik.inverses.second_order import upright
from robust_ik.kinematics.svd import svd, whole_svd
from robust_ik.robot.robot import Robot

SINGULAR = 1e-5
"""Largest σ/σ₁ that counts as lost: models with rounded numbers have no smaller one on some families."""
REGULAR = 0.05
"""Least σ/σ₁ of what is not lost, so that a scenario is about one singularity at a time."""
DRAWN = 256
"""Random configurations whose mean sets the length scale."""


class SingularFamily(Protocol):
    """What is read of a row of an atlas, such as `rik.Stratum`."""

    @property
    def corank(self) -> int:
        """How many directions are lost."""

    @property
    def samples(self) -> Array:
        """Members, joint values, (N, n)."""

    @property
    def words(self) -> str:
        """Its conditions."""


@dataclass(frozen=True, eq=False)
class SingularPoint:
    """A configuration of exact corank k.

    Attributes:
        values: Joint values, (n,).
        corank: k.
        exit: What becomes of a command along `lost[:, 0]`, as of `Robot.way_out`; the stronger of its two directions.
        lost: The lost directions, orthonormal in scaled rows, (m, k); the first one so that `exit` speaks of it.
        kernel: Joint motions that move nothing, orthonormal, (n, p); the first one is bent most along `lost[:, 0]`.
        across: The joint motion that leaves the family fastest, (n,), of length 1.
        place: The family, in words.
    """

    values: Array
    corank: int
    exit: Exit
    lost: Array
    kernel: Array
    across: Array
    place: str


def length_scale(robot: Robot, rng: np.random.Generator) -> float:
    """Root mean square of how far the tool's point moves by a radian of a joint, m: over random configurations."""
    turning = ~robot.sliding
    linear = robot.jacobian(robot.random(rng, DRAWN), rows=("x", "y", "z"))[..., turning]
    size = float(np.sqrt(np.mean(np.sum(linear**2, axis=-2)))) if turning.any() else 0.0
    return size if size > 0 else 1.0


def singular_points(
    robot: Robot, families: Iterable[SingularFamily], corank: int, length: float, rng: np.random.Generator
) -> Iterator[SingularPoint]:
    """Members of families of one corank, a member of each family in turn, as often as they last.

    Args:
        robot: The robot.
        families: Of its atlas.
        corank: k.
        length: Metres that count as much as a radian.
        rng: Decides which members come first.
    """
    found = [each for each in families if each.corank == corank]
    orders = [rng.permutation(len(each.samples)) for each in found]
    for turn in range(max(map(len, orders), default=0)):
        for family, order in zip(found, orders):
            if turn < len(order):
                point = singular_point(robot, family.samples[order[turn]], corank, length, family.words)
                if point is not None:
                    yield point


def singular_point(robot: Robot, values: Array, corank: int, length: float, place: str) -> SingularPoint | None:
    """What there is at a configuration; None if it is not of exactly this corank, or the arm is nearly singular else.

    The rank that the arm has anywhere is taken to be the smaller of m and n.
    """
    q = robot.configuration(values)
    units = np.array([length if row in ("x", "y", "z") else 1.0 for row in robot.rows])
    J, H = robot.jacobian(q) / units[:, None], robot.hessian(q) / units[:, None, None]
    found = whole_svd(J)
    s = found.s / found.s[0]
    r = len(s) - corank
    if r < 1 or s[r] > SINGULAR or s[r - 1] < REGULAR:
        return None
    lost, kernel = found.U[:, r : len(s)], found.Vt[r:].T
    told = {side: robot.way_out(q, side * units * lost[:, 0]) for side in (1.0, -1.0)}
    side = upright(lost[:, 0])
    if _strength(told[-side].exit) > _strength(told[side].exit):
        side = -side
    lost = side * lost
    bend = np.tensordot(lost[:, 0], 0.5 * (H + np.swapaxes(H, 1, 2)), 1)
    values_of, vectors = np.linalg.eigh(kernel.T @ bend @ kernel)
    kernel = kernel @ vectors[:, np.argsort(-values_of, kind="stable")]
    across = svd(bend @ kernel).U[:, 0]
    kernel, across = upright(kernel[:, 0]) * kernel, upright(across) * across
    return SingularPoint(np.array(values), corank, told[side].exit, lost, kernel, across, place)


def _strength(exit_: Exit) -> int:
    """What a command promises, so that of two opposite ones the more hopeful names the point."""
    order = (Exit.FREE, Exit.END_OF_REACH, Exit.STRUCTURAL, Exit.TURN_FIRST, Exit.BOTH_WAYS, Exit.FOLD)
    return order.index(exit_)
