"""The way out of a singular configuration: along a self-motion, the tool moves only in the lost direction.

To first order a self-motion v does not move the tool; to second order it moves it by κ s²/2 along a lost direction u,
where κ = uᵀ H[v, v]. Arrays only.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robust_ik.checks import Array, readonly
from robust_ik.kinematics.svd import svd, whole_svd
from robust_ik.kinematics.twist_rows import ROWS
from robust_ik.singularities.geometry.screw_chain import ScrewChain
from robust_ik.singularities.lost_motion.lost_motion import LostMotion


@dataclass(frozen=True, eq=False)
class SelfMotionWay:
    """The self-motion that leads out fastest, followed to both sides.

    Attributes:
        direction: Index of the lost direction along which it leads.
        curvature: κ, in the units of the twist per rad²; zero if nothing leads out to second order.
        motion: v, (n,).
        values: Joint values, (2 S + 1, n), the singular configuration in the middle.
    """

    direction: int
    curvature: float
    motion: Array
    values: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "motion", readonly(self.motion))
        object.__setattr__(self, "values", readonly(self.values))


def self_motion_way(
    chain: ScrewChain, values: Array, lost: LostMotion, reach: float = 0.5, steps: int = 24
) -> SelfMotionWay:
    """The way out of a singular configuration.

    Args:
        chain: What moves the tip.
        values: The configuration, (n,).
        lost: The motion that is lost there.
        reach: Length of the way to either side, rad or m.
        steps: Number of steps to either side.
    """
    chain, rows = replace(chain, length_scale=1.0), [ROWS.index(row) for row in chain.rows]
    H = chain.hessian(values)
    forms = [lost.self_motions.T @ np.tensordot(u[rows], H, 1) @ lost.self_motions for u in lost.twists.T]
    extremes = [np.linalg.eigh((form + form.T) / 2) for form in forms]
    sizes = [float(np.abs(found.eigenvalues).max()) for found in extremes]
    direction = int(np.argmax(sizes))
    found = extremes[direction]
    strongest = int(np.argmax(np.abs(found.eigenvalues)))
    v = lost.self_motions @ found.eigenvectors[:, strongest]
    v = v if v[np.abs(v).argmax()] > 0 else -v
    rank = chain.n - lost.self_motions.shape[1]
    kept = whole_svd(chain.jacobian(values)).U[:, :rank]
    ahead, back = (_carried(chain, values, kept, sign * v, reach / steps, steps) for sign in (1.0, -1.0))
    way = np.concatenate([back[:0:-1], ahead])
    return SelfMotionWay(direction, float(found.eigenvalues[strongest]), v, way)


def _carried(chain: ScrewChain, values: Array, kept: Array, v: Array, size: float, steps: int) -> Array:
    """Steps along v that keep the tool as still as possible in the directions `kept`, (m, m − k): midpoint rule."""
    way, along = [values], v
    for _ in range(steps):
        middle = _still(chain, way[-1] + size / 2 * along, kept, along)
        along = _still(chain, way[-1] + size * middle, kept, middle)
        way.append(way[-1] + size * middle)
    return np.stack(way)


def _still(chain: ScrewChain, values: Array, kept: Array, along: Array) -> Array:
    """The unit joint motion nearest to `along` that does not move the tool in the directions `kept`."""
    if kept.shape[1] == 0:
        return along
    found = svd(kept.T @ chain.jacobian(values))
    motion = along - found.Vt.T @ (found.Vt @ along)
    size = float(np.linalg.norm(motion))
    return np.asarray(motion / size if size > 1e-9 else along)
