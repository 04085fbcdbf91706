"""Dual quaternions of displacements and of axes, batched over leading axes: w x y z, then the dual part. Arrays only.

Source: Selig 2005, Geometric Fundamentals of Robotics, chapter 9. `kernels.branches.motors` is their compiled form.
"""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array

ONE = np.eye(8)[0]
"""No displacement."""


def unit(a: Array) -> Array:
    """The vector (3,) with length 1; products of rotations lose it by rounding."""
    return np.asarray(a / np.linalg.norm(a))


def line(direction: Array, point: Array) -> Array:
    """The axis a + ε m through a point, m = p × a, (8,)."""
    return np.concatenate([[0.0], direction, [0.0], np.cross(point, direction)])


def slide(direction: Array) -> Array:
    """The direction of a slide, ε a, (8,)."""
    return np.concatenate([np.zeros(5), direction])


def quaternion_product(a: Array, b: Array) -> Array:
    """A b, (..., 4) and (..., 4) → (..., 4)."""
    aw, av, bw, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    w = aw * bw - (av * bv).sum(axis=-1, keepdims=True)
    return np.concatenate([w, aw * bv + bw * av + np.cross(av, bv)], axis=-1)


def product(a: Array, b: Array) -> Array:
    """A b, (..., 8) and (..., 8) → (..., 8)."""
    ra, da, rb, db = a[..., :4], a[..., 4:], b[..., :4], b[..., 4:]
    dual = quaternion_product(ra, db) + quaternion_product(da, rb)
    return np.concatenate([quaternion_product(ra, rb), dual], axis=-1)


def conjugate(a: Array) -> Array:
    """The inverse of a unit motor, (..., 8)."""
    return np.asarray(a * np.array([1.0, -1.0, -1.0, -1.0] * 2))


def joint_motor(axis: Array, amount: float, slides: bool) -> Array:
    """The motor of a joint, (8,), for an angle or a length in units of the axes."""
    if slides:
        return np.asarray(ONE + 0.5 * amount * axis)
    return np.asarray(np.cos(0.5 * amount) * ONE + np.sin(0.5 * amount) * axis)


def moved(M: Array, axes: Array) -> Array:
    """M A M⁻¹ for each axis, (..., 8)."""
    return product(product(M, axes), conjugate(M))


def motor_of(T: Array, scale: float = 1.0) -> Array:
    """Unit motors of poses, (..., 4, 4) → (..., 8), lengths in units of `scale`; w ≥ 0 up to rounding.

    Source: Shepperd 1978: the largest of four candidates, so that nothing cancels.
    """
    R, t = T[..., :3, :3], T[..., :3, 3] / scale
    xx, yy, zz = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    a, b, c = R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]
    xy, xz, yz = R[..., 0, 1] + R[..., 1, 0], R[..., 0, 2] + R[..., 2, 0], R[..., 1, 2] + R[..., 2, 1]
    candidates = np.stack(
        [
            np.stack([1 + xx + yy + zz, a, b, c], axis=-1),
            np.stack([a, 1 + xx - yy - zz, xy, xz], axis=-1),
            np.stack([b, xy, 1 - xx + yy - zz, yz], axis=-1),
            np.stack([c, xz, yz, 1 - xx - yy + zz], axis=-1),
        ],
        axis=-2,
    )
    lengths = np.linalg.norm(candidates, axis=-1)
    best = lengths.argmax(axis=-1)[..., None, None]
    r = np.take_along_axis(candidates, best, axis=-2)[..., 0, :]
    r = r / np.linalg.norm(r, axis=-1, keepdims=True)
    r = np.where(r[..., :1] < 0, -r, r)
    pure = np.concatenate([np.zeros((*t.shape[:-1], 1)), t], axis=-1)
    return np.concatenate([r, 0.5 * quaternion_product(pure, r)], axis=-1)


def pose_of(M: Array, scale: float = 1.0) -> Array:
    """The pose of one unit motor, (8,) → (4, 4)."""
    w, v = M[0], M[1:4]
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    T = np.eye(4)
    T[:3, :3] = np.eye(3) + 2 * w * cross + 2 * cross @ cross
    T[:3, 3] = 2 * scale * quaternion_product(M[4:], conjugate(M)[:4])[1:]
    return T


def about_z(amount: float, slides: bool) -> Array:
    """The pose of a turn about z, or of a slide along it, (4, 4)."""
    T = np.eye(4)
    if slides:
        T[2, 3] = amount
    else:
        c, s = np.cos(amount), np.sin(amount)
        T[:2, :2] = [[c, -s], [s, c]]
    return T
