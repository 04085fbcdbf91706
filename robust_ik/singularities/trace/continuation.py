"""Follows a leaf straight on by predictor and corrector, until the path closes, ends or is long enough. Arrays only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.svd import svd
from robust_ik.singularities.conditions.angle_sums import wrapped
from robust_ik.singularities.families.leaf import CLEAN, Leaf, Mask
from robust_ik.singularities.find.projection_search import project
from robust_ik.singularities.find.tangent_walk import REFUSED, tangents, tangents_at
from robust_ik.singularities.geometry.screw_chain import ScrewChain

STEP, SHORTEST = 0.06, 1e-4
"""Longest and shortest step, rad or m."""
SMALLER, LARGER = 0.6, 1.5
"""Factors on the step: after it was refused, and after it was taken. Chosen: slow enough not to alternate."""
STRAIGHT = 0.995
"""Least cosine between successive directions, 6°: a chord then leaves the curve by a hundredth of its length."""
ALMOST = 1e-13
"""‖r‖/σ₁ to be reached by the corrector."""
BESIDE = 0.05
"""The path is closed if a step passes its start within this fraction of the step."""
MOST_STEPS = 20_000
"""Most steps of a path without a given length.

Chosen: 190 full turns at the longest step; stops paths that never close.
"""


@dataclass(frozen=True, eq=False)
class Followed:
    """A path along a leaf.

    Attributes:
        values: Joint values, (N, n), the start first; free joints keep their start values.
        heading: Unit direction at the start, (n,).
        closed: Whether it came back to its start.
    """

    values: Array
    heading: Array
    closed: bool


def followed(
    chain: ScrewChain, leaf: Leaf, start: Array, heading: Array | None = None, length: float = np.inf
) -> Followed:
    """The path from a point of a leaf, as straight as the leaf allows, with free joints at rest.

    Args:
        chain: What moves the tip.
        leaf: The leaf; its coupled joints move.
        start: A point of the leaf, (n,).
        heading: The direction, (n,); default along the strongest tangent.
        length: Largest length of the path, rad or m.
    """
    P = tangents(chain, start[None], leaf.corank, np.array([leaf.dimension]))[0]
    along = first = _heading(leaf, P, heading)
    points, size, gone = [start], STEP, 0.0
    while len(points) < MOST_STEPS and gone < length and np.any(along):
        there, P = _stepped(chain, leaf, points[-1], along, size)
        onward = _heading(leaf, P, along)
        # A path that leaves the range of a sliding joint is followed up to its end.
        if onward @ along < STRAIGHT or outside(chain, there):
            size *= SMALLER
            if size < SHORTEST:
                break
            continue
        if len(points) > 2 and _passes(chain, points[-1], there, start) and along @ first > 0:
            return Followed(np.stack(points), first, True)
        gone += float(np.linalg.norm(there - points[-1]))
        points.append(there)
        along, size = onward, min(STEP, LARGER * size)
    return Followed(np.stack(points), first, False)


def _heading(leaf: Leaf, P: Array, wanted: Array | None) -> Array:
    """The unit tangent of the coupled joints that is nearest to a direction; zero if there is none.

    Args:
        leaf: The leaf.
        P: Projector onto its tangent space, (n, n).
        wanted: The direction, (n,); default the strongest.
    """
    P = np.array(P)
    P[list(leaf.free)] = 0.0
    P[:, list(leaf.free)] = 0.0
    along = svd(P).U[:, 0] if wanted is None else P @ wanted
    size = float(np.linalg.norm(along))
    return np.asarray(along / size if size > 0 else along)


def _stepped(chain: ScrewChain, leaf: Leaf, here: Array, along: Array, size: float) -> tuple[Array, Array]:
    """A step along the leaf, and the projector onto the tangent space there; zero if the corrector went too far."""
    predicted = here + size * along
    found = project(chain, leaf.corank, predicted[None], ALMOST)
    there = np.array(found.values)
    there[:, list(leaf.free)] = here[list(leaf.free)]
    there = leaf.pinned(there)
    short = np.linalg.norm(there[0] - predicted) <= REFUSED * size
    if not (short and found.residual.relative[0] < CLEAN and leaf.holds(there)[0]):
        return there[0], np.zeros((chain.n, chain.n))
    return there[0], tangents_at(found.residual, np.array([leaf.dimension]))[0]


def _passes(chain: ScrewChain, before: Array, after: Array, start: Array) -> bool:
    """Whether the start lies on the chord of a step, modulo whole turns."""
    chord, away = after - before, wrapped(start - before, chain.period)
    length = float(np.linalg.norm(chord))
    share = float(away @ chord) / length**2
    beside = float(np.linalg.norm(away - share * chord))
    return 0.0 < share <= 1.0 and beside < BESIDE * length


def outside(chain: ScrewChain, values: Array) -> Mask:
    """Whether a joint that slides has left its range at joint values (..., n), (...)."""
    beyond = (values < chain.lower) | (values > chain.upper)
    return np.asarray(np.any(beyond & ~np.isfinite(chain.period), axis=-1))
