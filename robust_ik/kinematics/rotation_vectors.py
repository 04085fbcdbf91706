"""Rotations as vectors along their axes with their angles as lengths, and back, batched over leading axes.

Arrays only.
"""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array


def rotations(vectors: Array) -> Array:
    """Rotations about vectors, (..., 3), by their lengths: (..., 3, 3)."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)
    half = np.sinc(angle / (2 * np.pi)) ** 2 / 2
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * cross + half * cross @ cross)


def rotation_vector(R: Array) -> Array:
    """The logarithm of rotation matrices, (..., 3, 3) → (..., 3), by the quaternion's largest component."""
    quaternion = _quaternion(R)
    sine = np.sqrt((quaternion[..., 1:] ** 2).sum(axis=-1, keepdims=True))
    angle = 2 * np.arctan2(sine, quaternion[..., :1])
    small = sine < 1e-9
    factor = np.where(small, 2.0, angle / np.where(small, 1.0, sine))
    return np.asarray(factor * quaternion[..., 1:])


def _quaternion(R: Array) -> Array:
    """Unit quaternions (w, x, y, z) with w ≥ 0, from the row with the largest pivot, which keeps every digit."""
    flat = np.reshape(R, (-1, 3, 3))
    diagonal = np.diagonal(flat, axis1=1, axis2=2)
    # Row i is 4 q_i (w, x, y, z).
    rows = np.empty((len(flat), 4, 4))
    rows[:, 1:, 1:] = flat + flat.transpose(0, 2, 1)
    twice = flat[:, [2, 0, 1], [1, 2, 0]] - flat[:, [1, 2, 0], [2, 0, 1]]
    rows[:, 0, 1:], rows[:, 1:, 0] = twice, twice
    rows[:, range(4), range(4)] = 1 + diagonal @ _SIGNS
    pivot = np.argmax(np.diagonal(rows, axis1=1, axis2=2), axis=1)
    row = rows[np.arange(len(flat)), pivot]
    row *= np.where(row[:, :1] < 0, -1.0, 1.0) / np.sqrt((row**2).sum(axis=1, keepdims=True))
    return np.reshape(row, (*np.shape(R)[:-2], 4))


_SIGNS = np.array([[1.0, 1.0, -1.0, -1.0], [1.0, -1.0, 1.0, -1.0], [1.0, -1.0, -1.0, 1.0]])
"""Columns: the signs of xx, yy, zz in 4 w² − 1, 4 x² − 1, 4 y² − 1, 4 z² − 1."""
