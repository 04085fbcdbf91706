"""Fits relations to points of a stratum: the only combination of a few products that vanishes there. Arrays only."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.kinematics.svd import svd
from robust_ik.singularities.conditions.angle_sums import Angle
from robust_ik.singularities.conditions.relation_bases import Basis, Known, linear_bases, other_bases, product_bases
from robust_ik.singularities.conditions.trig_relations import Relation

SHORT, SHORT_ODD = 12, 6
"""Most terms of a short relation, and of one with half angles or higher degrees."""
FITS = 1e-8
"""Singular value of the fitted products, relative to the largest one, below which a relation fits."""
TOLD_APART = 1e-6
"""Singular values above this are not zero if they are roots of eigenvalues of AᵀA.

Derivation: of the some 30 columns of a basis rounding leaves up to 1e-7; ten times that.
"""
UNIQUE = 1e-5
"""The next singular value must be above this; else several relations fit, and a smaller basis is needed."""
EXACT, RESOLVED = 1e-14, 1e-9
"""If there is none, one that fits up to rounding is taken, and the next singular value must only be above RESOLVED:
points of a family that is nearly a point leave it small.
"""
ZERO_COEFFICIENT = 1e-7
"""Coefficients below this fraction of the largest one are rounding. Chosen: ten times what FITS lets pass."""
SMALLEST = 1e-4
"""Smallest coefficient of a relation that is not zero: points of a nearly degenerate family fit smaller ones."""
TRIMS = 3
"""Most fits, each without the outliers of the one before. Chosen: fewer leave some in, more take longer."""
OUTLIER = 30.0
"""Points whose residual is this many times the median lie at crossings of strata."""
TOGETHER = 64
"""Most bases that are tried at once. Chosen: their products take up to four megabytes."""

Mask = NDArray[np.bool_]
Limits = tuple[float, float]
"""FITS and UNIQUE, or EXACT and RESOLVED."""
Stage = Callable[[Sequence[Angle]], list[Basis]]
"""The bases for some angles, in the order in which they are tried."""


def simplest(
    choices: Sequence[Sequence[Angle]], values: Array, *, odd: bool = False, known: Known | None = None
) -> Relation | None:
    """The relation with the fewest terms, over sets of angles with the same condition; None if none is short.

    Args:
        choices: Sets of angles of which no subset is related.
        values: Points of one stratum, (N, n).
        odd: Whether to try half angles and higher degrees too, and points close together: of one component only.
        known: Values of functions at these points, kept from one call to the next.
    """
    known = {} if known is None else known
    plain: tuple[Stage, ...] = (linear_bases, product_bases)
    strict, exact = (FITS, UNIQUE), (EXACT, RESOLVED)
    stages = [(stage, strict) for stage in (*plain, *([other_bases] if odd else []))]
    for stage, limits in (*stages, *((stage, exact) for stage in plain if odd)):
        bases = _hopeful([stage(angles) for angles in choices], values, limits, known)
        fits = (_first_fit(each, values, limits, known) for each in bases)
        most = SHORT_ODD if stage is other_bases else SHORT
        short = [each for each in fits if each is not None and len(each.terms) <= most]
        if short:
            return min(short, key=lambda relation: (len(relation.terms), _factors(relation)))
    return None


def _hopeful(choices: Sequence[list[Basis]], values: Array, limits: Limits, known: Known) -> list[list[Basis]]:
    """Of each list the bases in which one relation may fit, and for which there are points enough."""
    by_size: dict[int, list[Basis]] = {}
    for basis in dict.fromkeys(basis for bases in choices for basis in bases):
        if len(values) >= 2 * len(basis):
            by_size.setdefault(len(basis), []).append(basis)
    hopeful: set[Basis] = set()
    for bases in by_size.values():
        for first in range(0, len(bases), TOGETHER):
            tried = bases[first : first + TOGETHER]
            may = _may_fit(np.stack([basis.at(values, known) for basis in tried]), limits)
            hopeful.update(tried[int(place)] for place in np.flatnonzero(may))
    return [[basis for basis in bases if basis in hopeful] for bases in choices]


def _may_fit(products: Array, limits: Limits) -> Mask:
    """Whether just one combination of products (B, N, t) may vanish at all points but outliers, (B,).

    Eigenvalues of AᵀA are quick, and are squares: they tell 1e-6 from 0, but not 1e-8. Where no point stands out of the
    best combination, none is left out of the fit that `_null_vector` makes. Two that vanish at all points do at fewer.
    """
    squares, vectors = np.linalg.eigh(np.swapaxes(products, 1, 2) @ products)
    sizes = np.abs(products @ vectors[:, :, :1])[..., 0]
    zero = squares <= (TOLD_APART**2 * squares[:, -1:])
    result = zero[:, 0] | (sizes.max(axis=1) > _outlying(sizes))
    if limits[1] > TOLD_APART and products.shape[2] > 1:
        result &= ~zero[:, 1]
    return np.asarray(result)


def _outlying(sizes: Array) -> Array:
    """The residual above which points are outliers, (..., N) → (...)."""
    half = sizes.shape[-1] // 2
    middle = np.partition(sizes, half, axis=-1)[..., half]
    return np.maximum(OUTLIER * middle, FITS)


def _first_fit(bases: Sequence[Basis], values: Array, limits: Limits, known: Known) -> Relation | None:
    fitting = (_null_vector(basis, values, limits, known) for basis in bases)
    return next((relation for relation in fitting if relation is not None), None)


def _null_vector(basis: Basis, values: Array, limits: Limits, known: Known) -> Relation | None:
    """The only combination of products that vanishes at the points, without outliers; None if it is not unique."""
    products = basis.at(values, known)
    kept = np.ones(len(values), dtype=bool)
    for _ in range(TRIMS):
        found = svd(products[kept])
        vector = found.Vt[-1]
        size = np.abs(products @ vector)
        limit = float(_outlying(size))
        if kept.sum() < 2 * len(basis) or (size <= limit)[kept].all():
            break
        kept = size <= limit
    s = found.s / found.s[0]
    fits, unique = limits
    if s[-1] > fits or (len(s) > 1 and s[-2] < unique) or kept.sum() < 0.9 * len(values):
        return None
    vector = vector / vector[int(np.argmax(np.abs(vector)))]
    large = np.abs(vector) > ZERO_COEFFICIENT
    if np.abs(vector[large]).min() < SMALLEST:
        return None
    chosen = tuple(term for term, big in zip(basis.terms, large) if big)
    residual = float(np.abs(products[kept][:, large] @ vector[large]).max())
    return Relation(chosen, vector[large], residual, int(kept.sum()))


def _factors(relation: Relation) -> int:
    """The number of functions in a relation; sums of joints count more."""
    return sum(1 + len(factor.angle.joints) for term in relation.terms for factor in term)
