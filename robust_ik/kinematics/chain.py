"""A chain of joints as constants: its kinematics are functions of q, for any number of q at once. Arrays only.

They are compiled, and agree to 1e-12 with those of Pinocchio, from which the constants come. A chain is a product of
exponentials (Murray, Li, Sastry 1994, eq. (3.3)) with each axis turned to z, so that a joint costs one product by a
constant rotation and one by a planar one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array, readonly
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import svd
from robust_ik.kinematics.twist_rows import ROWS

REFERENCES = ("local_world_aligned", "local", "world")
"""References of Jacobians, in the order of their numbers in kernels."""


@dataclass(frozen=True, eq=False)
class Chain:
    """The c joints that move a frame.

    Attributes:
        n: Number of the robot's independent joints.
        nq: Length of q.
        rotations: From each joint's axis frame (z is the axis) to the next one's at zero, (c, 3, 3).
        origins: Origin of each axis frame in the one before, m, (c, 3).
        sliding: Which joints slide, (c,).
        column: For each joint, the independent joint that it follows: a column of J, (c,).
        factor: Its motion per motion of that independent joint, (c,).
        shift: Its motion if that independent joint is at zero, (c,).
        place: Index in q of that independent joint, (c,).
        circling: Whether q holds cosine and sine there, (c,).
        tip: The frame in the last axis frame, (4, 4).
    """

    n: int
    nq: int
    rotations: Array
    origins: Array
    sliding: NDArray[np.bool_]
    column: NDArray[np.int_]
    factor: Array
    shift: Array
    place: NDArray[np.int_]
    circling: NDArray[np.bool_]
    tip: Array

    def __post_init__(self) -> None:
        for each in fields(self)[2:]:
            value = getattr(self, each.name)
            object.__setattr__(self, each.name, readonly(value, np.asarray(value).dtype))

    def __len__(self) -> int:
        return len(self.sliding)

    @cached_property
    def packed(self) -> Array:
        """The chain as a vector for kernels; see `kernels.chain.chain_layout`."""
        from robust_ik.kernels.chain import chain_layout as links  # no Numba yet

        joints = np.zeros((len(self), links.STRIDE))
        joints[:, links.ROTATION : links.ROTATION + 9] = self.rotations.reshape(-1, 9)
        joints[:, links.ORIGIN : links.ORIGIN + 3] = self.origins
        direct = self.circling & ~self.sliding & (self.factor == 1) & (self.shift == 0)
        plain = np.where(self.sliding, links.SLIDING, links.TURNING)
        joints[:, links.KIND] = np.where(direct, links.CIRCLING, plain + links.FOLLOWING * self.circling)
        joints[:, links.PLACE], joints[:, links.COLUMN] = self.place, self.column
        joints[:, links.FACTOR], joints[:, links.SHIFT] = self.factor, self.shift
        head = np.array([len(self), self.n, self.nq, 0.0])
        return readonly(np.concatenate([head, joints.ravel(), self.tip[:3, :3].ravel(), self.tip[:3, 3]]))

    def poses(self, q: Array) -> Array:
        """Poses of the frame, (..., nq) → (..., 4, 4)."""
        from robust_ik.kernels.chain import poses

        return self._each(poses, q, (4, 4))

    def jacobians(self, q: Array, reference: str) -> Array:
        """Jacobians, (..., nq) → (..., 6, n)."""
        from robust_ik.kernels.chain import jacobians

        return self._each(jacobians, q, (6, self.n), number_of(reference))

    def hessians(self, q: Array, reference: str) -> Array:
        """∂J_ij/∂q_k, (..., nq) → (..., 6, n, n)."""
        from robust_ik.kernels.chain import hessians

        return self._each(hessians, q, (6, self.n, self.n), number_of(reference))

    def contractions(self, q: Array, wrenches: Array, motions: Array, *, paired: bool = False) -> Array:
        """Σ wrench_i (∂J_ij/∂q_k) motion_j for every k, without ∂J/∂q; reference "local_world_aligned".

        Args:
            q: Of N configurations, (N, nq).
            wrenches: Weights of the rows of J, (N, a, 6).
            motions: Weights of its columns, (N, b, n).
            paired: Combine the i-th wrench with the i-th motion only; a = b.

        Returns:
            (N, a, b, n), or (N, a, n).
        """
        from robust_ik.kernels.chain import contractions

        pairs = wrenches.shape[1:2] if paired else (wrenches.shape[1], motions.shape[1])
        result = np.empty((len(q), *pairs, self.n))
        given = (np.ascontiguousarray(each, dtype=float) for each in (q, wrenches, motions))
        contractions(self.packed, *given, int(paired), result.reshape(len(q), math.prod(pairs), self.n))
        return result

    def singular_value_gradients(self, q: Array, rows: Sequence[str]) -> Array:
        """∂σᵢ/∂q_k of the Jacobian, world axes at the frame's point, without its Hessian.

        Args:
            q: Of N configurations, (N, nq).
            rows: Task rows, of x y z wx wy wz.

        Returns:
            (N, k, n) with k = min(len(rows), n); row i belongs to σᵢ.
        """
        places = [ROWS.index(name) for name in rows]
        found = svd(np.take(self.jacobians(q, "local_world_aligned"), places, axis=1))
        wrenches = np.zeros((len(q), found.s.shape[1], len(ROWS)))
        wrenches[..., places] = np.swapaxes(found.U, 1, 2)
        return self.contractions(q, wrenches, found.Vt, paired=True)

    def _each(self, kernel: Callable[..., Any], q: Array, shape: tuple[int, ...], *options: int) -> Array:
        result = np.empty((*q.shape[:-1], *shape))
        given = np.ascontiguousarray(q).reshape(-1, self.nq)
        kernel(self.packed, given, result.reshape(len(given), *shape), *options)
        return result


def number_of(reference: str) -> int:
    """The number of a reference in kernels.

    Raises:
        InputError: There is no such reference.
    """
    if not isinstance(reference, str) or reference not in REFERENCES:
        raise InputError(f"reference must be one of {', '.join(REFERENCES)}, got {reference!r}")
    return REFERENCES.index(reference)


def axis_frames(axes: Array, points: Array, tip: Array) -> tuple[Array, Array, Array]:
    """Frames on the axes of joints, z along the axis, each relative to the one before.

    Args:
        axes: Unit vectors with all joints at zero, world, (c, 3).
        points: A point on each, (c, 3).
        tip: The pose of the moved frame, (4, 4).

    Returns:
        Rotations (c, 3, 3) and origins (c, 3) in the frame before, the first one in the world, and the pose of the
        moved frame in the last one, (4, 4).
    """
    rotation, origin = np.eye(3), np.zeros(3)
    rotations, origins = np.empty((len(axes), 3, 3)), np.empty((len(axes), 3))
    for index, (axis, point) in enumerate(zip(axes, points)):
        frame = _with_z(axis)
        rotations[index], origins[index] = rotation.T @ frame, rotation.T @ (point - origin)
        rotation, origin = frame, point
    last = np.eye(4)
    last[:3, :3], last[:3, 3] = rotation.T @ tip[:3, :3], rotation.T @ (tip[:3, 3] - origin)
    return rotations, origins, last


def _with_z(axis: Array) -> Array:
    """A rotation whose third column is the unit axis."""
    x = np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis], axis=-1)
