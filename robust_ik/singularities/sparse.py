"""Rotating a subspace's basis to directions that a person can name. Arrays only."""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array, as_array
from robust_ik.errors import InputError

SWEEPS = 200
STILL = 1e-12
RESTARTS = 20


def sparse_basis(basis: Array, *, rng: np.random.Generator | None = None) -> Array:
    """The orthonormal basis of the same subspace whose entries are as near to 0 or large as can be.

    Maximises Σ (entries)⁴ over rotations (quartimax) by sweeps over pairs of columns, from the basis as it is and from
    random turns of it. Columns are ordered by their largest entry's row and have that entry positive: signs and order
    of a basis mean nothing.

    Args:
        basis: Orthonormal columns, (m, k).
        rng: For the turns; the same ones by default.

    Source: Almarkhi-Maciejewski, section 2.3, with quartimax as the measure.
    """
    basis = as_array(basis, "basis", (None, None))
    if basis.ndim != 2:
        raise InputError(f"basis must be one matrix, got shape {basis.shape}")
    if basis.shape[1] < 2:
        return _ordered(basis)
    rng = rng or np.random.default_rng(0)
    turns = [np.eye(basis.shape[1]), *(_turn(rng, basis.shape[1]) for _ in range(RESTARTS))]
    found = [_swept(basis @ turn) for turn in turns]
    best = max(float((each**4).sum()) for each in found)
    # Of equally good ones the first: the result does not hang on the last digit.
    return _ordered(next(each for each in found if (each**4).sum() > best - 1e-9))


def _turn(rng: np.random.Generator, k: int) -> Array:
    return np.asarray(np.linalg.qr(rng.normal(size=(k, k)))[0])


def _swept(columns: Array) -> Array:
    """Sweeps over all pairs of columns until none turns any more."""
    columns = columns.copy()
    for _ in range(SWEEPS):
        largest = 0.0
        for i in range(columns.shape[1]):
            for j in range(i + 1, columns.shape[1]):
                angle = _best_angle(columns[:, i], columns[:, j])
                c, s = np.cos(angle), np.sin(angle)
                columns[:, [i, j]] = columns[:, [i, j]] @ np.array([[c, -s], [s, c]])
                largest = max(largest, abs(angle))
        if largest < STILL:
            break
    return columns


def _best_angle(x: Array, y: Array) -> float:
    """The turn of two columns that makes the sum of fourth powers largest."""
    u, v = x * x - y * y, 2 * x * y
    return float(np.arctan2(2 * (u @ v), (u @ u) - (v @ v))) / 4


def _ordered(columns: Array) -> Array:
    """Columns by the row of their largest entry, that entry positive; ties by size."""
    rows = np.abs(columns).argmax(axis=0)
    signs = np.where(columns[rows, np.arange(columns.shape[1])] < 0, -1.0, 1.0)
    return np.asarray((columns * signs)[:, np.argsort(rows, kind="stable")])
