"""Self-motions: curves of configurations that keep a pose, followed to both sides of one of them. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robust_ik.branches.dual_quaternions import ONE, conjugate, joint_motor, moved, product
from robust_ik.checks import Array

STEP, MOST_POINTS = 0.05, 2000
"""How far a solution is tried to be left, rad and units of length; how many points a curve may have to either side."""
ON_CURVE = 1e-11
"""Largest entry of the error of a point that counts as on the curve."""
LOST = 1e-6
"""Singular values up to this part of the largest one count as zero."""
AT_LIMIT = 1e-9
"""By how much a joint may pass its limit, rad or units of length."""
NEXT_TO, SAME = 0.2, 0.02
"""How far from a curve's point a solution may be to lie between it and the next one; how far from their line."""


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """Joints in a row whose motors shall multiply to g, or take a point to where g takes it.

    Attributes:
        axes: (k, 8).
        slides: (k,).
        g: (8,).
        point: (3,); if `rotates` is False, its position alone is wanted.
        rotates: Whether the rotation is wanted, too.
        lower: Limits of the first joints, those of the arm.
        upper: The same.
    """

    axes: Array
    slides: NDArray[np.bool_]
    g: Array
    point: Array
    rotates: bool
    lower: Array
    upper: Array

    def state(self, values: Array) -> tuple[Array, Array]:
        """The twist to g, (6,) or (3,), and the Jacobian, (6, k) or (3, k)."""
        M, columns = ONE, []
        for axis, slides, value in zip(self.axes, self.slides, values):
            columns.append(moved(M, axis))
            M = product(M, joint_motor(axis, float(value), bool(slides)))
        J = np.stack(columns, axis=-1)
        if self.rotates:
            error = product(self.g, conjugate(M))
            w = np.copysign(max(abs(error[0]), 0.1), error[0])
            return 2 * error[[1, 2, 3, 5, 6, 7]] / w, J[[1, 2, 3, 5, 6, 7]]
        at = placed(M, self.point)
        return placed(self.g, self.point) - at, J[5:] + np.cross(J[1:4], at, axis=0)

    def difference(self, a: Array, b: Array) -> Array:
        """A − b, turns modulo 2π, (..., k) or of the first joints alone."""
        d = a - b
        return np.where(self.slides[: d.shape[-1]], d, d - 2 * np.pi * np.round(d / (2 * np.pi)))

    def corrected(self, values: Array, rank: int) -> Array | None:
        """The values on the curve next to these, by Newton steps of a rank; None if there are none."""
        for _ in range(8):
            error, J = self.state(values)
            if np.abs(error).max() < ON_CURVE:
                return values
            U, s, Vt = np.linalg.svd(J, full_matrices=False)
            if not s[rank - 1] > 0:
                return None
            values = values + Vt[:rank].T @ (U[:, :rank].T @ error / s[:rank])
        return None

    @cached_property
    def free(self) -> ClosedLoop:
        """The same loop without limits."""
        none = np.full(len(self.lower), np.inf)
        return ClosedLoop(self.axes, self.slides, self.g, self.point, self.rotates, -none, none)


def placed(M: Array, point: Array) -> Array:
    """Where a motor takes a point, (3,)."""
    after = product(product(M, np.array([1.0, 0, 0, 0, 0, *point])), conjugate(M) * np.array([1.0] * 4 + [-1.0] * 4))
    return np.asarray(after[5:])


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
    _, s, Vt = np.linalg.svd(J)
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
            s = np.linalg.svd(loop.state(there)[1], compute_uv=False)
            if rank < len(s) and s[rank] > LOST * s[0]:
                return False
    return True


def _follow(loop: ClosedLoop, start: Array, rank: int, sign: float) -> tuple[Array, bool]:
    """Points to one side, (p, k), and whether the curve comes back to its start."""
    from robust_ik.kernels.branches import follow_curve

    out = np.zeros((MOST_POINTS, len(start)))
    count = follow_curve.compiled(
        np.ascontiguousarray(loop.axes), loop.slides.astype(float), np.ascontiguousarray(loop.g),
        np.ascontiguousarray(loop.point), 6 if loop.rotates else 3, rank, len(loop.lower),
        np.ascontiguousarray([loop.lower, loop.upper]), np.ascontiguousarray(start), sign, out,
    )  # fmt: skip
    closed = count < 0
    return out[: -1 - count if closed else count], closed
