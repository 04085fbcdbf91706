"""Finds points of every corank from random starts, many at once. NumPy only."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from robust_ik.checks import Array, as_array, checked_parameter
from robust_ik.errors import InputError
from robust_ik.kinematics.svd import singular_values
from robust_ik.singularities.find.gradient_search import gradient_search
from robust_ik.singularities.find.points_found import Points
from robust_ik.singularities.find.projection_search import TOLERANCE, SearchEnds
from robust_ik.singularities.find.projection_search import project as project
from robust_ik.singularities.find.rank_residual import Indices, Mask, check_corank, ranks
from robust_ik.singularities.geometry.screw_chain import ScrewChain

Progress = Callable[[int, int], None]
Method = Literal["projection", "gradient"]

CHUNK = 1024
"""Starts that are searched at once: they take a few megabytes."""
PUSH, PUSHES = 0.7, 4
"""Standard deviation of the random motion of a search that stalls, rad or m, and how often: most stall at saddles."""
SHAKES = (0.05, 0.1, *[0.25] * 6)
"""Standard deviations of the random motions of a point at a crossing, before it is projected again, rad or m."""
NEARBY = 2e-4
"""Distance around a point at which its stratum is sampled to measure its dimension, rad or m."""


def find_points(
    chain: ScrewChain,
    corank: int,
    starts: int | ArrayLike = 1000,
    rng: np.random.Generator | None = None,
    *,
    method: Method = "projection",
    tolerance: float = TOLERANCE,
    measured: bool = True,
    progress: Progress | None = None,
) -> Points:
    """Configurations whose corank is at least k, from random starts, without regard to joint limits.

    Args:
        chain: What moves the tip.
        corank: k, from 1 to the rank where the arm is not singular.
        starts: Number of uniform starts within the chain's ranges, or the starts themselves, (S, n).
        rng: Random numbers for the starts and for motions of stalled searches; the same ones by default.
        method: "projection" (Levenberg-Marquardt on the residual), or "gradient", the paper's own, for comparison.
        tolerance: ‖r‖/σ₁ that counts as zero, r being the residual: the k smallest singular values.
        measured: Whether to measure the dimension by samples if ∂r/∂q does not give it; otherwise n − rank is used.
        progress: Called with (starts done, starts in all).

    Raises:
        InputError: The chain cannot have this corank, there is no such method, or the robot has fewer joints than task
            rows.
    """
    check_corank(chain, corank)
    if method not in ("projection", "gradient"):
        raise InputError(f"method must be 'projection' or 'gradient', got {method!r}")
    tolerance = checked_parameter("tolerance", tolerance, above=0)
    rng = np.random.default_rng(0) if rng is None else rng
    begin = starts_of(chain, starts, rng)
    parts = []
    for first in range(0, len(begin), CHUNK):
        part = begin[first : first + CHUNK]
        if method == "gradient":
            found = gradient_search(chain, corank, part, tolerance)
        else:
            found = search(chain, corank, part, _normals([rng], [len(part)], chain.n), tolerance)
        parts.append(points_of(chain, corank, found, rng, tolerance, measured=measured))
        if progress is not None:
            progress(min(first + CHUNK, len(begin)), len(begin))
    return Points.joined(parts)


def find_together(
    chain: ScrewChain, corank: int, starts: Sequence[int], rngs: Sequence[np.random.Generator], tolerance: float
) -> list[Points]:
    """The points of several searches, each with its own random numbers: the same bits as of each alone.

    All go step by step together: most steps are of the last few starts, and take as long for those of several searches.

    Args:
        chain: What moves the tip.
        corank: k.
        starts: Number of random starts of each search.
        rngs: Random numbers of each.
        tolerance: As for `find_points`; dimensions are not measured.
    """
    begin = np.concatenate([chain.random(rng, count) for rng, count in zip(rngs, starts)])
    found = search(chain, corank, begin, _normals(rngs, starts, chain.n), tolerance)
    parts = np.split(np.arange(len(begin)), np.cumsum(starts)[:-1])
    return [
        points_of(chain, corank, found.select(part), rng, tolerance, measured=False) for part, rng in zip(parts, rngs)
    ]


Normals = Callable[[Indices], Array]
"""Normal random numbers, (N, n), for the starts with these indices, ascending, (N,)."""


def _normals(rngs: Sequence[np.random.Generator], starts: Sequence[int], n: int) -> Normals:
    """Random numbers of each search for its own starts."""
    ends = np.cumsum(starts)

    def drawn(which: Indices) -> Array:
        counts = np.diff(np.searchsorted(which, ends), prepend=0)
        return np.concatenate([rng.standard_normal((count, n)) for rng, count in zip(rngs, counts)])

    return drawn


def starts_of(chain: ScrewChain, starts: int | ArrayLike, rng: np.random.Generator) -> Array:
    """The given starts, or a given number of random ones, (S, n).

    Raises:
        InputError: They are neither.
    """
    if isinstance(starts, (int, np.integer)) and not isinstance(starts, bool):
        if starts < 1:
            raise InputError(f"starts must be at least 1, got {starts}")
        return chain.random(rng, int(starts))
    given = as_array(starts, "starts", (None, chain.n))
    if given.ndim != 2 or len(given) == 0:
        raise InputError(f"starts must be a count or have shape (S, {chain.n}), got {given.shape}")
    return given


def search(chain: ScrewChain, corank: int, starts: Array, normals: Normals, tolerance: float = TOLERANCE) -> SearchEnds:
    """Projects starts (N, n) to the corank; pushes those that stall, and shakes those that end at a crossing.

    A point is kept if no shake leads to a clear point of exactly that corank.
    """
    found = project(chain, corank, starts, tolerance)
    for _ in range(PUSHES):
        again = np.flatnonzero(~found.converged)
        if again.size == 0:
            break
        other = project(chain, corank, found.values[again] + PUSH * normals(again), tolerance)
        found.put(again, other, other.residual.norm < found.residual.norm[again])
    for size in SHAKES:
        again = np.flatnonzero(found.converged & ~_clear(found, corank))
        if again.size == 0:
            break
        other = project(chain, corank, found.values[again] + size * normals(again), tolerance)
        found.put(again, other, other.converged & _clear(other, corank))
    return found


def _clear(found: SearchEnds, corank: int) -> Mask:
    at = found.residual
    return np.asarray((at.coranks == corank) & ranks(at.derivative, at.scale)[1])


def points_of(
    chain: ScrewChain,
    corank: int,
    found: SearchEnds,
    rng: np.random.Generator,
    tolerance: float = TOLERANCE,
    *,
    measured: bool = True,
) -> Points:
    """The result of a search as points, with the local dimension of the stratum at each."""
    hit = np.flatnonzero(found.converged)
    values, at = found.values[hit], found.residual.select(hit)
    rank, clear = ranks(at.derivative, at.scale)
    dimensions = chain.n - rank
    if measured:
        dimensions[~clear] = local_dimensions(chain, corank, values[~clear], rng, tolerance)
    return Points(
        corank=corank,
        values=chain.wrapped(values),
        residual=at.relative,
        iterations=found.tries[hit],
        coranks=at.coranks,
        dimensions=dimensions,
        folded=~clear,
        minima=chain.wrapped(found.values[~found.converged]),
        floors=found.residual.relative[~found.converged],
    )


def local_dimensions(
    chain: ScrewChain, corank: int, values: Array, rng: np.random.Generator, tolerance: float = TOLERANCE
) -> Indices:
    """The dimension of the stratum around singular points, measured by samples, without the rank of ∂r/∂q.

    Args:
        chain: What moves the tip.
        corank: Its corank.
        values: Points on it, (N, n).
        rng: Random numbers for the samples.
        tolerance: As for `find_points`.

    Returns:
        Dimensions (N,) of the spans of nearby points after projection.
    """
    count = 2 * chain.n
    around = np.repeat(values, count, axis=0)
    around = around + NEARBY * rng.standard_normal(around.shape)
    found = project(chain, corank, around, tolerance)
    moves = (found.values - np.repeat(values, count, axis=0)) * found.converged[:, None] / NEARBY
    return np.asarray(np.sum(singular_values(moves.reshape(-1, count, chain.n)) > 0.2, axis=1))
