"""The gradients of singular values that are a cluster: rotated, so that they agree, or the shortest of their means.

A block holds u_aᵀ (∂J/∂q) v_b of the c pairs of a cluster, (N, c, c, n). Arrays only.

Source: Almarkhi-Maciejewski, section 2.2, eqs. (12) and (14).
"""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.svd import singular_values

ANGLES = np.linspace(0.0, np.pi / 2, 24, endpoint=False)
"""The grid for the rotation of two clustered vectors, rad. Chosen: steps of 3.75°.

A quarter turn swaps them, to the same angles: with both ends in it, rounding would choose.
"""
SWEEPS = 3
"""Sweeps over all pairs of a cluster of three or more. Chosen: turns of one pair move the others, but less and less."""
SHORTENINGS = 200
"""Steps towards the shortest mean.

Chosen: of random blocks of two and three pairs, no mean was then shorter by 1 % (a test holds it); more take longer.
"""


def rotated_gradients(block: Array) -> Array:
    """The gradients of clustered singular values, in the bases in which their directions agree best.

    Pairs (u, v) are rotated by eq. (12), plane by plane, to the least sum of angles, eq. (14).

    Args:
        block: u_aᵀ (∂J/∂q) v_b within the clusters, (N, c, c, n).

    Returns:
        (N, c, n).
    """
    return np.asarray(np.einsum("naak->nak", rotated_block(block)))


def rotated_block(block: Array) -> Array:
    """The blocks (N, c, c, n) of the pairs so rotated, whose diagonals are these gradients."""
    block = block.copy()
    size = block.shape[1]
    for _ in range(1 if size == 2 else SWEEPS):
        for a in range(size):
            for b in range(a + 1, size):
                block = _turned(block, a, b)
    return block


def _turned(block: Array, a: int, b: int) -> Array:
    """The blocks (N, c, c, n) after the best rotation of ANGLES in the plane of pairs a and b."""
    turn = np.broadcast_to(np.eye(block.shape[1]), (len(ANGLES), block.shape[1], block.shape[1])).copy()
    turn[:, a, a] = turn[:, b, b] = np.cos(ANGLES)
    turn[:, a, b], turn[:, b, a] = np.sin(ANGLES), -np.sin(ANGLES)
    turned = np.einsum("pac,ncdk,pbd->npabk", turn, block, turn, optimize=True)
    gradients = np.einsum("npaak->npak", turned)
    unit = gradients / np.maximum(np.linalg.norm(gradients, axis=-1, keepdims=True), 1e-300)
    angles = np.arccos(np.clip(unit @ np.swapaxes(unit, -1, -2), -1.0, 1.0))
    return np.asarray(turned[np.arange(len(block)), np.argmin(angles.sum(axis=(-2, -1)), axis=1)])


def shortest_mean(block: Array) -> Array:
    """The shortest of all means that eqs. (12) and (13) can make, with whatever φ and γ, (N, n).

    Of equal singular values all fall fastest against it, to first order; if it is zero, the largest falls nowhere.
    Means are Σ Z_ab u_aᵀ (∂J/∂q) v_b with Z positive semidefinite of trace 1: Z by accelerated projected gradients.

    Args:
        block: u_aᵀ (∂J/∂q) v_b within the clusters, (N, c, c, n).
    """
    count, size = block.shape[:2]
    even = (block + np.swapaxes(block, 1, 2)) / 2
    steepest = singular_values(even.reshape(count, size**2, -1))[:, 0] ** 2
    step = (1.0 / np.where(steepest > 0, steepest, 1.0))[:, None, None]
    Z = ahead = np.broadcast_to(np.eye(size) / size, (count, size, size))
    for turn in range(SHORTENINGS):
        mean = np.einsum("nab,nabk->nk", ahead, even)
        before, Z = Z, _weights(ahead - step * np.einsum("nabk,nk->nab", even, mean))
        ahead = Z + turn / (turn + 3) * (Z - before)
    return np.asarray(np.einsum("nab,nabk->nk", Z, even))


def _weights(A: Array) -> Array:
    """The nearest positive semidefinite matrices of trace 1 to symmetric ones, (N, c, c)."""
    values, vectors = np.linalg.eigh(A)
    falling = values[:, ::-1]
    excess = (np.cumsum(falling, axis=1) - 1) / np.arange(1, A.shape[1] + 1)
    kept = np.sum(falling > excess, axis=1)
    values = np.maximum(values - excess[np.arange(len(A)), kept - 1][:, None], 0.0)
    return np.asarray((vectors * values[:, None]) @ np.swapaxes(vectors, 1, 2))
