"""Span of a chain's links: a bound on the distance of its frame, whatever the angles of its joints."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.kinematics.chain import Chain

ROUNDS = 60
"""Number of reweightings. Chosen: for eight arms the bound is then within 1 mm of its least, 1.6 mm after 40."""
MOST_CORNERS = 6
"""Most sliding joints with some travel between two that turn; with more of them there is no bound."""
SHORTEST = 1e-9
"""Gaps between axes count as at least this, in units of length."""


@dataclass(frozen=True, eq=False)
class Span:
    """A bound: a point of the tool is never farther than `distance` from a point of the world.

    Attributes:
        centre: The point of the world, (3,), m.
        carried: The point of the tool, in its own frame, (3,), m.
        distance: m; infinite if unknown.
    """

    centre: Array
    carried: Array
    distance: float


def find_span(chain: Chain, lower: Array, upper: Array, *, oriented: bool) -> Span:
    """The sum of the lengths of links, made small; each link joins a point on one axis to a point on the next.

    Any choice of points on the axes of turning joints gives a bound, since the distances of these points do not change.
    A sum of lengths is convex in the positions of the points, and reweighted least squares find its minimum.

    Args:
        chain: The joints that move the frame.
        lower: Limits of the robot's n joints, (n,).
        upper: The same.
        oriented: Whether the frame's rotation is known: the point may then lie on the last axis.

    Source: Weiszfeld 1937.
    """
    ends = np.sort(np.stack([lower[chain.column], upper[chain.column]]) * chain.factor + chain.shift, axis=0)
    finite = np.isfinite(ends).all(axis=0)
    low, high = np.where(finite, ends, 0.0)
    middle, half = (low + high) / 2, np.where(finite, (high - low) / 2, np.inf)
    axes, origins, tip = at_zero(chain, np.where(chain.sliding, middle, 0.0))
    turning = np.flatnonzero(~chain.sliding)
    nodes, directions = origins[turning], axes[turning]
    on_axis = oriented and len(turning) > 0 and turning[-1] == len(chain) - 1
    if not on_axis:
        nodes, directions = np.vstack([nodes, tip[:3, 3]]), np.vstack([directions, np.zeros(3)])
    points = nodes + _closest(nodes, directions)[:, None] * directions
    begins = [0, *(turning + 1).tolist()]
    joints = [range(begin, end) for begin, end in itertools.pairwise([*begins, len(chain)])]
    slides = [[i for i in each if chain.sliding[i]] for each in joints]
    links = np.vstack([np.zeros((1, 3)), np.diff(points, axis=0)])
    total = sum((_farthest(link, axes[each], half[each]) for link, each in zip(links, slides)), 0.0)
    return Span(points[0], tip[:3, :3].T @ (points[-1] - tip[:3, 3]), total)


def at_zero(chain: Chain, slid: Array) -> tuple[Array, Array, Array]:
    """Axes, points on them, and the pose of the frame, with turning joints at zero and sliding ones at `slid`."""
    T, axes, origins = np.eye(4), np.empty((len(chain), 3)), np.empty((len(chain), 3))
    for i in range(len(chain)):
        T[:3, 3] += T[:3, :3] @ chain.origins[i]
        T[:3, :3] = T[:3, :3] @ chain.rotations[i]
        axes[i], origins[i] = T[:3, 2], T[:3, 3]
        T[:3, 3] += slid[i] * T[:3, 2]
    return axes, origins, T @ chain.tip


def _closest(nodes: Array, directions: Array) -> Array:
    """Positions of points along their lines that make the sum of distances from one to the next small."""
    along = np.zeros(len(nodes))
    for _ in range(ROUNDS):
        gaps = np.diff(nodes + along[:, None] * directions, axis=0)
        weights = np.sqrt(1 / np.maximum(np.linalg.norm(gaps, axis=1), SHORTEST))
        rows = np.zeros((3 * len(gaps), len(nodes)))
        for i, weight in enumerate(weights):
            rows[3 * i : 3 * i + 3, i], rows[3 * i : 3 * i + 3, i + 1] = (
                -weight * directions[i],
                weight * directions[i + 1],
            )
        wanted = -(weights[:, None] * np.diff(nodes, axis=0)).ravel()
        along = np.linalg.lstsq(rows, wanted, rcond=None)[0] if len(gaps) else along
    return along


def _farthest(link: Array, axes: Array, half: Array) -> float:
    """The greatest length of a link over the travel of the sliding joints in it; it is attained at a corner."""
    axes, half = axes[half > 0], half[half > 0]
    if len(half) > MOST_CORNERS or not np.isfinite(half).all():
        return math.inf
    corners = np.array(list(itertools.product((-1.0, 1.0), repeat=len(half))))
    return float(np.linalg.norm(link + (corners * half) @ axes, axis=1).max())
