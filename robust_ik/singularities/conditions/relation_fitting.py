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
    return simplest_each([choices], values, odd=odd, known=known)[0]


def simplest_each(
    groups: Sequence[Sequence[Sequence[Angle]]], values: Array, *, odd: bool = False, known: Known | None = None
) -> list[Relation | None]:
    """`simplest` of each group, whose bases are tried together."""
    known = {} if known is None else known
    plain: tuple[Stage, ...] = (linear_bases, product_bases)
    strict, exact = (FITS, UNIQUE), (EXACT, RESOLVED)
    stages = [(stage, strict) for stage in (*plain, *([other_bases] if odd else []))]
    found: list[Relation | None] = [None] * len(groups)
    for stage, limits in (*stages, *((stage, exact) for stage in plain if odd)):
        most = SHORT_ODD if stage is other_bases else SHORT
        bases = {place: [stage(angles) for angles in groups[place]] for place, each in enumerate(found) if each is None}
        hopeful = _hopeful([basis for each in bases.values() for some in each for basis in some], values, limits, known)
        for place, each in bases.items():
            tried = [[basis for basis in some if basis in hopeful] for some in each]
            fits = [_first_fit(some, values, limits, known) for some in tried if some]
            short = [relation for relation in fits if relation is not None and len(relation.terms) <= most]
            if short:
                found[place] = min(short, key=lambda relation: (len(relation.terms), _factors(relation)))
    return found


def _hopeful(bases: Sequence[Basis], values: Array, limits: Limits, known: Known) -> set[Basis]:
    """The bases in which one relation may fit, and for which there are points enough."""
    by_size: dict[int, list[Basis]] = {}
    for basis in dict.fromkeys(bases):
        if len(values) >= 2 * len(basis):
            by_size.setdefault(len(basis), []).append(basis)
    hopeful: set[Basis] = set()
    for alike in by_size.values():
        for first in range(0, len(alike), TOGETHER):
            tried = alike[first : first + TOGETHER]
            may = _may_fit(np.stack([basis.at(values, known) for basis in tried]), limits)
            hopeful.update(tried[int(place)] for place in np.flatnonzero(may))
    return hopeful


def _may_fit(products: Array, limits: Limits) -> Mask:
    """Whether just one combination of products (B, N, t) may vanish at all points but outliers, (B,).

    Eigenvalues of AᵀA are quick, and are squares: they tell 1e-6 from 0, but not 1e-8. Points are left out as
    `_null_vector` does. Two combinations that vanish at all points do at fewer.
    """
    result = np.zeros(len(products), dtype=bool)
    tried, kept = np.arange(len(products)), np.ones(products.shape[:2], dtype=bool)
    for fit in range(TRIMS):
        part = products[tried]
        used = part * kept[..., None] if fit else part
        squares, vectors = np.linalg.eigh(np.swapaxes(used, 1, 2) @ used)
        zero = squares <= (TOLD_APART**2 * squares[:, -1:])
        if limits[1] > TOLD_APART and products.shape[2] > 1:
            zero[:, 0] &= ~zero[:, 1]
        result[tried] = zero[:, 0]
        sizes = np.abs(part @ vectors[:, :, :1])[..., 0]
        within = sizes <= _outlying(sizes)[:, None]
        enough = kept.sum(axis=1) >= 2 * products.shape[2]
        more = ~zero[:, 0] & enough & (kept & ~within).any(axis=1)
        tried, kept = tried[more], within[more]
    return result


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
