"""Self-motions: curves of configurations that keep a pose, followed to both sides of one of them. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.branches.closed_loop import ClosedLoop
from robust_ik.checks import Array
from robust_ik.kinematics.svd import full_svd, singular_values

STEP, MOST_POINTS = 0.05, 2000
"""How far a solution is tried to be left, rad and units of length; how many points a curve may have to either side."""
LOST = 1e-6
"""Singular values up to this part of the largest one count as zero."""
AT_LIMIT = 1e-9
"""By how much a joint may pass its limit, rad or units of length."""
NEXT_TO, SAME = 0.2, 0.02
"""How far from a curve's point a solution may be to lie between it and the next one; how far from their line."""


@dataclass(frozen=True, eq=False)
class Traced:
    """A traced curve.

    Attributes:
        values: Points in order, (p, k).
        closed: Whether the last point is followed by the first one.
    """

    values: Array
    closed: bool

    def holds(self, loop: ClosedLoop, values: Array) -> bool:
        """Whether a solution, of all joints or of the first ones, lies on the line of two neighbours of the curve."""
        points = self.values[:, : len(values)]
        d = loop.difference(points, values)
        i = int(np.argmin(np.linalg.norm(d, axis=1)))
        if np.linalg.norm(d[i]) > NEXT_TO:
            return False
        for j in (i - 1, i + 1):
            if not self.closed and not 0 <= j < len(d):
                continue
            along = d[j % len(d)] - d[i]
            square = float(along @ along)
            if 0 < square < 1 and np.linalg.norm(d[i] - min(max(d[i] @ along / square, -1), 0) * along) < SAME:
                return True
        return bool(np.linalg.norm(d[i]) < 1e-3)

    def nearest(self, loop: ClosedLoop, values: Array) -> Array:
        """The values of the first joints at the point next to given ones."""
        points = self.values[:, : len(values)]
        return np.asarray(points[np.argmin(np.linalg.norm(loop.difference(points, values), axis=1))])


def within_limits(loop: ClosedLoop, curve: Traced, near: Array) -> list[Traced]:
    """The pieces of a curve that lie within the loop's limits, each joint turned to the value next to `near`."""
    own = len(near)
    values, slides = curve.values.copy(), loop.slides[:own]
    turn = 2 * np.pi * ~slides
    with np.errstate(invalid="ignore"):
        turned = values[:, :own] + turn * np.round((near - values[:, :own]) / (2 * np.pi))
        turned -= turn * np.maximum(np.ceil((turned - loop.upper - AT_LIMIT) / (2 * np.pi)), 0)
        turned += turn * np.maximum(np.ceil((loop.lower - AT_LIMIT - turned) / (2 * np.pi)), 0)
    values[:, :own] = turned
    inside = ((turned <= loop.upper + AT_LIMIT) & (turned >= loop.lower - AT_LIMIT)).all(axis=1)
    pieces: list[Traced] = []
    for i in np.flatnonzero(inside):
        if any(piece.holds(loop, values[i, :own]) for piece in pieces):
            continue
        piece = trace(loop, values[i])
        if isinstance(piece, Traced):
            pieces.append(piece)
    return pieces


def trace(loop: ClosedLoop, start: Array) -> Traced | int:
    """The curve through a solution; else the dimension of what it lies on: 0 for an isolated one, 2 or more.

    Args:
        loop: The closed loop; the curve ends at its limits.
        start: A solution, (k,).
    """
    _, J = loop.state(start)
    found = full_svd(J)
    s, Vt = found.s, found.Vt
    rank = int((s > LOST * s[0]).sum())
    dimension = len(start) - rank
    if dimension == 0 or not _moves(loop, start, Vt[rank:], rank):
        return 0
    if dimension > 1:
        return dimension
    forward, closed = _follow(loop, start, rank, 1.0)
    if closed:
        return Traced(np.array([start, *forward]), closed=True)
    backward, _ = _follow(loop, start, rank, -1.0)
    return Traced(np.array([*backward[::-1], start, *forward]), closed=False)


def _moves(loop: ClosedLoop, start: Array, directions: Array, rank: int) -> bool:
    """Whether a solution can be left along each direction, and stays one, of the same rank."""
    for direction in directions:
        for sign in (1.0, -1.0):
            there = loop.corrected(start + sign * STEP * direction, rank)
            if there is None or abs(loop.difference(there, start) @ direction) < 0.5 * STEP:
                return False
            s = singular_values(loop.state(there)[1])
            if rank < len(s) and s[rank] > LOST * s[0]:
                return False
    return True


def _follow(loop: ClosedLoop, start: Array, rank: int, sign: float) -> tuple[Array, bool]:
    """Points to one side, (p, k), and whether the curve comes back to its start."""
    from robust_ik.kernels.branches import follow_curve

    out = np.zeros((MOST_POINTS, len(start)))
    count = follow_curve.compiled(
        *loop.given, 6 if loop.rotates else 3, rank, len(loop.lower),
        np.ascontiguousarray([loop.lower, loop.upper]), np.ascontiguousarray(start), sign, out,
    )  # fmt: skip
    closed = count < 0
    return out[: -1 - count if closed else count], closed
