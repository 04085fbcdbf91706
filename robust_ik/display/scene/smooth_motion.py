"""Directions and poses that change in time without flicker. Arrays only.

A singular vector has no sign, equal singular values leave their vectors free to rotate, and the order of singular
values changes. Here each vector is the continuation of the one before.
"""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.kinematics.svd import svd

EQUAL = 1e-3
"""Singular values closer than this fraction of the largest one count as equal: their vectors may be rotated."""


def full_basis(J: Array) -> tuple[Array, Array]:
    """All m task directions of J (..., m, n), U (..., m, m), and their singular values (..., m), zeros for m > n."""
    decomposition = svd(J)
    U, s = decomposition.U, decomposition.s
    missing = U.shape[-2] - U.shape[-1]
    if missing:
        rest = svd(np.eye(U.shape[-2]) - U @ np.swapaxes(U, -1, -2)).U[..., :missing]
        U, s = np.concatenate([U, rest], axis=-1), np.concatenate([s, np.zeros((*s.shape[:-1], missing))], axis=-1)
    return U, s


def follow(J: Array) -> tuple[Array, Array]:
    """The task directions of a sequence of Jacobians, each column the continuation of the one before.

    Args:
        J: Jacobians, (N, m, n).

    Returns:
        U (N, m, m) and their singular values s (N, m), no longer in descending order.
    """
    U, s = (np.array(found) for found in full_basis(J))
    for i in range(1, len(J)):
        U[i], s[i] = _continued(U[i], s[i], U[i - 1])
    return U, s


def _continued(U: Array, s: Array, before: Array) -> tuple[Array, Array]:
    """U's columns reordered, signed and, for equal singular values, rotated, to be nearest to `before`."""
    overlap = U.T @ before
    strength = overlap**2
    groups = _groups(s)
    for group in groups:
        strength[group] = strength[group].mean(axis=0)
    orders = _permutations(len(s))
    order = orders[np.argmax(strength[orders, np.arange(len(s))].sum(axis=1))]
    place = np.argsort(order)
    turned = np.empty_like(U)
    for group in groups:
        turned[:, place[group]] = U[:, group] @ _nearest_turn(overlap[np.ix_(group, place[group])])
    return turned, s[order]


def follow_subspace(bases: Array, first: Array) -> Array:
    """Bases of a moving subspace, each rotated within it to be nearest to the one before.

    Args:
        bases: Orthonormal columns in any order, (N, m, k).
        first: Columns to which the first basis is made nearest, (m, k).
    """
    turned, before = np.empty_like(bases), first
    for i, basis in enumerate(bases):
        turned[i] = before = basis @ _nearest_turn(basis.T @ before)
    return turned


def _nearest_turn(overlap: Array) -> Array:
    """The orthogonal matrix nearest to the overlap (k, k) of two bases of one space (Procrustes)."""
    if len(overlap) == 1:
        return np.where(overlap < 0, -1.0, 1.0)
    decomposition = svd(overlap)
    return np.asarray(decomposition.U @ decomposition.Vt)


def _groups(s: Array) -> list[NDArray[np.int_]]:
    """Indices of descending singular values, in groups of equal ones."""
    breaks = np.flatnonzero(s[:-1] - s[1:] > EQUAL * max(s[0], np.finfo(float).tiny)) + 1
    return np.split(np.arange(len(s)), breaks)


@cache
def _permutations(count: int) -> NDArray[np.int_]:
    return np.array(list(itertools.permutations(range(count))))


def carried_frames(directions: Array) -> Array:
    """Rotations whose z axis points along directions (N, 3), with as little rotation about it as possible.

    A direction of length zero keeps the frame before it. Returns (N, 3, 3).
    """
    frames, current = [], np.eye(3)
    for direction in np.asarray(directions, dtype=float):
        length = float(np.linalg.norm(direction))
        if length > 0:
            current = _squared(_shortest_turn(current[:, 2], direction / length) @ current, direction / length)
        frames.append(current)
    return np.stack(frames) if frames else np.empty((0, 3, 3))


def _squared(R: Array, z: Array) -> Array:
    """R with exactly z as third axis and the others perpendicular to it, so that rounding does not accumulate."""
    x = R[:, 0] - (R[:, 0] @ z) * z
    x /= np.linalg.norm(x)
    return np.column_stack([x, _cross(z, x), z])


def _shortest_turn(a: Array, b: Array) -> Array:
    """The rotation by the smallest angle that brings unit vector a to b."""
    cosine = float(a @ b)
    if cosine < -1 + 1e-6:
        axis = _cross(a, np.eye(3)[np.argmin(np.abs(a))])
        axis /= np.linalg.norm(axis)
        return np.asarray(2 * np.outer(axis, axis) - np.eye(3))
    x, y, z = _cross(a, b)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1 + cosine))


def _cross(a: Array, b: Array) -> Array:
    """The cross product a × b; NumPy's own takes ten times as long for one pair."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def right_handed(axes: Array) -> Array:
    """Orthonormal frames (N, 3, 3); in left-handed ones the third axis is reversed."""
    axes = axes.copy()
    axes[np.linalg.det(axes) < 0, :, 2] *= -1
    return axes


def quaternions(R: Array) -> Array:
    """Unit quaternions (x, y, z, w) of rotations (N, 3, 3), with the sign that is nearest to the one before."""
    xx, yy, zz = R[:, 0, 0], R[:, 1, 1], R[:, 2, 2]
    wx, wy, wz = R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]
    xy, xz, yz = R[:, 0, 1] + R[:, 1, 0], R[:, 0, 2] + R[:, 2, 0], R[:, 1, 2] + R[:, 2, 1]
    # Row i is 4 qᵢ (x, y, z, w); the one with the largest qᵢ keeps every digit.
    rows = np.stack(
        [
            np.stack([1 + xx - yy - zz, xy, xz, wx], axis=-1),
            np.stack([xy, 1 - xx + yy - zz, yz, wy], axis=-1),
            np.stack([xz, yz, 1 - xx - yy + zz, wz], axis=-1),
            np.stack([wx, wy, wz, 1 + xx + yy + zz], axis=-1),
        ],
        axis=1,
    )
    best = np.argmax(np.diagonal(rows, axis1=1, axis2=2), axis=1)
    q = rows[np.arange(len(R)), best]
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    agreement = np.einsum("ni,ni->n", q[1:], q[:-1])
    signs = np.cumprod(np.concatenate([[1.0], np.where(agreement < 0, -1.0, 1.0)])) if len(q) else np.ones(0)
    return np.asarray(q * signs[:, None])
