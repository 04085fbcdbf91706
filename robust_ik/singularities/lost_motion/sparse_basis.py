"""Rotates a subspace's basis to directions that are easy to name. Arrays only."""

from __future__ import annotations

from functools import cache
from itertools import combinations

import numpy as np

from robust_ik.checks import Array, as_measures, readonly
from robust_ik.checks.public_arguments import checked
from robust_ik.errors import InputError

SWEEPS = 200
"""Most sweeps. Chosen: random subspaces of three to six dimensions took up to 140."""
STILL = 1e-12
"""Turns below this, rad, are rounding: a sweep without larger ones is the last."""
RESTARTS = 20
"""Random rotations to start from, since sweeps end at local maxima. Chosen: more miss the best basis more rarely."""
ORTHONORMAL = 1e-6
"""Largest entry of BᵀB − I of a basis B that counts as orthonormal.

Chosen: bases from an SVD are a billion times better; printed digits are worse, and want `numpy.linalg.qr` first.
"""


@checked
def sparse_basis(basis: Array, *, rng: np.random.Generator | None = None) -> Array:
    """The orthonormal basis of the same subspace whose entries are, as far as possible, either near 0 or large.

    Maximises Σ (entries)⁴ over rotations (quartimax) by sweeps over pairs of columns, from the given basis and from
    random rotations of it. Columns are ordered by their largest entry's row and have that entry positive, since signs
    and order of a basis have no meaning.

    Args:
        basis: Orthonormal columns, (m, k): the directions in which a tool cannot move, say, from
            `robust_ik.lost_directions`.
        rng: Random numbers for the rotations; the same ones by default.

    Returns:
        Orthonormal columns, (m, k), in the frame and the units of those given. Twists in other units have another
        sparse basis.

    Raises:
        InputError: The columns are not orthonormal.

    Source: Almarkhi-Maciejewski, section 2.3, with quartimax as the measure.
    """
    basis = as_measures(basis, "basis", (None, None))
    if basis.ndim != 2 or len(basis) == 0:
        raise InputError(f"basis must be one matrix with rows, got shape {basis.shape}")
    off = float(np.abs(basis.T @ basis - np.eye(basis.shape[1])).max(initial=0.0))
    if off > ORTHONORMAL:
        raise InputError(f"basis must have orthonormal columns, got BᵀB that differs from the identity by {off:.2g}")
    if basis.shape[1] < 2:
        return _ordered(basis)
    found = _swept(basis @ (_turns(basis.shape[1]) if rng is None else _random_turns(basis.shape[1], rng)))
    size = (found**4).sum(axis=(1, 2))
    # Of equally good ones the first, so that the result does not depend on the last digit.
    return _ordered(found[np.argmax(size > size.max() - 1e-9)])


@cache
def _turns(k: int) -> Array:
    return readonly(_random_turns(k, np.random.default_rng(0)))


def _random_turns(k: int, rng: np.random.Generator) -> Array:
    """The identity, and random rotations, (1 + RESTARTS, k, k)."""
    return np.concatenate([np.eye(k)[None], np.linalg.qr(rng.normal(size=(RESTARTS, k, k)))[0]])


def _swept(columns: Array) -> Array:
    """Sweeps over all pairs of columns, (N, m, k), until none rotates any more."""
    columns = np.array(columns)
    for _ in range(SWEEPS):
        largest = 0.0
        for i, j in combinations(range(columns.shape[2]), 2):
            x, y = columns[..., i].copy(), columns[..., j].copy()
            angle = _best_angles(x, y)
            c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
            columns[..., i], columns[..., j] = c * x + s * y, c * y - s * x
            largest = max(largest, float(np.abs(angle).max()))
        if largest < STILL:
            break
    return columns


def _best_angles(x: Array, y: Array) -> Array:
    """The rotations of pairs of columns, (N, m) each, that maximise the sum of fourth powers, (N,)."""
    u, v = x * x - y * y, 2 * x * y
    return np.asarray(np.arctan2(2 * (u * v).sum(axis=1), (u * u - v * v).sum(axis=1)) / 4)


def _ordered(columns: Array) -> Array:
    """Columns in the order of the row of their largest entry, which is made positive; ties by magnitude."""
    rows = np.abs(columns).argmax(axis=0)
    signs = np.where(columns[rows, np.arange(columns.shape[1])] < 0, -1.0, 1.0)
    return np.asarray((columns * signs)[:, np.argsort(rows, kind="stable")])
