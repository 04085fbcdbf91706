"""The motion that is lost at a singular configuration: twists, wrench screws, self-motions, a way out. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array, as_array, readonly
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import whole_svd
from robust_ik.singularities.lost_motion.sparse_basis import sparse_basis
from robust_ik.singularities.lost_motion.wrench_screw import WrenchScrew


@dataclass(frozen=True, eq=False)
class LostMotion:
    """The motion that is lost at a singular configuration of corank k.

    An arm with fewer joints than rows, or whose joints do not move its tip independently, cannot move it in some
    directions wherever it is. What it loses besides are those that come back as it leaves the singular configuration,
    one way or another: r of them.

    Attributes:
        twists: Directions in which the tool cannot move, world axes at the tool's point, orthonormal and sparse
            columns, (6, k), or (6, r), linear rows first; zero in rows that the task does not have.
        tool_twists: The same subspace along the tool's axes, sparse columns of its own, shaped alike.
        screws: The wrenches that the structure bears, one for each column of `twists`.
        self_motions: Joint motions that do not move the tool, orthonormal columns, (n, n − rank).
        origin: The tool's point, (3,), m, about which moments are taken.
        curvature: For each column of `twists`, the smallest and the largest of uᵀ H[v, v] over unit self-motions v,
            (k, 2), in the units of the twist per rad². If both have one sign, the tool can leave along u to one side
            only, as at the end of its reach; with both signs, to both sides. If they are zero, it cannot leave to
            second order.
    """

    twists: Array
    tool_twists: Array
    screws: tuple[WrenchScrew, ...]
    self_motions: Array
    origin: Array
    curvature: Array

    def __post_init__(self) -> None:
        for name in ("twists", "tool_twists", "self_motions", "origin", "curvature"):
            object.__setattr__(self, name, readonly(getattr(self, name)))

    @property
    def corank(self) -> int:
        """How many directions are lost; of an arm that never has full rank in all rows not the corank."""
        return int(self.twists.shape[1])


FLAT = 1e-7
"""Curvature, in units of the twist per rad², below which a self-motion does not lead along a lost direction."""
VANISHED = 1e-7
"""Derivatives of U₂ᵀ J V₂ below this fraction of the largest entry of ∂J/∂q count as zero."""
ALL_ROWS = (0, 1, 2, 3, 4, 5)
"""Indices of the rows of a twist, position first."""


def lost_motion(
    J: Array,
    hessian: Array,
    T_world_tool: Array,
    corank: int,
    rows: tuple[int, ...] = ALL_ROWS,
    rank: int | None = None,
) -> LostMotion:
    """The motion that is lost at a configuration of a known corank.

    Args:
        J: Jacobian, world axes at the tool's point, (m, n).
        hessian: ∂J/∂q, (m, n, n).
        T_world_tool: The tool's pose, (4, 4).
        corank: k ≥ 1.
        rows: Which of the six rows of a twist J has.
        rank: g, the rank where the arm is not singular; by default min(m, n).

    Raises:
        InputError: Shapes do not fit, or the corank is not in [1, g].
    """
    J = as_array(J, "J", (len(rows), None))
    m, n = J.shape
    hessian, T = as_array(hessian, "hessian", (m, n, n)), as_array(T_world_tool, "T_world_tool", (4, 4))
    rank = min(m, n) if rank is None else rank
    if not 1 <= corank <= rank <= min(m, n):
        raise InputError(f"corank must lie in [1, {rank}] for {m} rows and {n} joints, got {corank}")
    lost = lost_directions(J, hessian, corank, rank)
    basis = np.zeros((6, lost.shape[1]))
    basis[list(rows)] = lost
    twists = sparse_basis(basis)
    self_motions = whole_svd(J).Vt[rank - corank :].T
    turn = np.kron(np.eye(2), T[:3, :3].T)
    return LostMotion(
        twists=twists,
        tool_twists=sparse_basis(turn @ twists),
        screws=tuple(WrenchScrew.of(column, T[:3, 3]) for column in twists.T),
        self_motions=self_motions,
        origin=T[:3, 3],
        curvature=np.array([_curvature(column[list(rows)], hessian, self_motions) for column in twists.T]),
    )


def lost_directions(J: Array, hessian: Array, corank: int, rank: int | None = None) -> Array:
    """The directions of the task that are lost at a configuration of corank k, orthonormal columns, (m, k) or (m, r).

    With a rank of m elsewhere they are the k weakest left singular vectors. With a rank of g < m there are always m − g
    such vectors: those are lost along which a small motion of some joint lets the self-motions move the tool, as the
    derivative of U₂ᵀ J V₂ shows; all of them if it vanishes.

    Args:
        J: The Jacobian, (m, n).
        hessian: ∂J/∂q, (m, n, n).
        corank: k ≥ 1.
        rank: g, the rank where the arm is not singular; by default min(m, n).
    """
    rank = min(J.shape) if rank is None else rank
    found, kept = whole_svd(J), rank - corank
    weakest = found.U[:, kept:]
    if J.shape[0] == rank:
        return np.asarray(weakest)
    change = np.einsum("ia,ijk,bj->abk", weakest, hessian, found.Vt[kept:])
    gained = whole_svd(change.reshape(weakest.shape[1], -1))
    count = int(np.sum(gained.s > VANISHED * np.abs(hessian).max(initial=0.0)))
    return np.asarray(weakest @ gained.U[:, :count] if count else weakest)


def sides(low: float, high: float) -> int:
    """To how many sides self-motions lead out along a lost direction, to second order, by the extremes of κ: 0 to 2."""
    return int(low < -FLAT) + int(high > FLAT)


def _curvature(u: Array, hessian: Array, motions: Array) -> tuple[float, float]:
    """Extremes of uᵀ H[v, v] over unit self-motions."""
    form = motions.T @ np.tensordot(u, hessian, 1) @ motions
    values = np.linalg.eigvalsh((form + form.T) / 2)
    return float(values[0]), float(values[-1])
