"""Counts the connected pieces of a leaf, angles modulo 2π. Arrays only."""

from __future__ import annotations

from itertools import product

import numpy as np
import scipy.ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from robust_ik.checks import Array
from robust_ik.singularities.conditions.angle_sums import wrapped
from robust_ik.singularities.families.leaf import Leaf
from robust_ik.singularities.find.rank_residual import Residual
from robust_ik.singularities.find.tangent_walk import REFUSED, Indices, polish, readable_at, tangents_at, walk
from robust_ik.singularities.geometry.screw_chain import ScrewChain

GRID = {1: 720, 2: 240, 3: 60}
"""Cells along each angle of the grid for a relation of one, two or three joints."""
POINTS, LENGTH = 60, 0.25
"""Number of walks from samples, and length of a step, rad or m."""
WALKS = (15, 15, 30)
"""Numbers of steps after which it is checked whether all walks are linked."""
NEAR = 0.5
"""Distance within which walks may be linked, rad or m."""
STEP, STEPS = 0.12, 12
"""Length, rad or m, and most steps of a walk between two places.

Chosen: NEAR is five straight steps; the rest is for bends.
"""
ROUNDS = 6
"""Most rounds of linking. Chosen: if pieces join two by two, all POINTS of them are one after six rounds."""


def count_components(chain: ScrewChain, leaf: Leaf, rng: np.random.Generator) -> tuple[int, bool]:
    """The number of pieces and whether it is exact; pinned and free joints alone make one piece.

    For a single relation of up to three joints it is counted on a grid; otherwise samples are linked by walks.
    """
    if not leaf.relations and not leaf.curve:
        return 1, True
    if len(leaf.relations) == 1 and not leaf.curve:
        pinned = {joint for pin in leaf.pins if len(pin.angle.joints) == 1 for joint in pin.angle.joints}
        joints = [joint for joint in leaf.relations[0].joints if joint not in pinned]
        if (
            _sums_follow(leaf, pinned | set(joints))
            and len(joints) in GRID
            and (count := _on_grid(chain, leaf, joints))
        ):
            return count, False
    return _linked(chain, leaf, rng), False


def _sums_follow(leaf: Leaf, known: set[int]) -> bool:
    """Whether each pinned sum of joints has one joint of its own that follows the others, so that pieces stay apart."""
    sums = [set(pin.angle.joints) - known for pin in leaf.pins if len(pin.angle.joints) > 1]
    return all(len(each) == 1 for each in sums) and len(set().union(*sums)) == len(sums)


def _on_grid(chain: ScrewChain, leaf: Leaf, joints: list[int]) -> int:
    """Pieces of the zero set of the relation: groups of grid cells at whose corners it has both signs."""
    cells = GRID[len(joints)]
    axes = [np.linspace(chain.lower[joint], chain.upper[joint], cells + 1) + 0.01234 for joint in joints]
    values = np.zeros((*(len(axis) for axis in axes), chain.n))
    for pin in leaf.pins:
        if len(pin.angle.joints) == 1:
            values[..., pin.angle.joints[0]] = pin.angle.signs[0] * pin.value
    for joint, grid in zip(joints, np.meshgrid(*axes, indexing="ij")):
        values[..., joint] = grid
    f = leaf.relations[0].of(values)
    corners = [f[tuple(slice(o, o + cells) for o in offset)] for offset in product((0, 1), repeat=len(joints))]
    crossed = (np.min(corners, axis=0) < 0) & (np.max(corners, axis=0) > 0)
    numbers, count = scipy.ndimage.label(crossed)
    links = [np.empty((0, 2), dtype=int)]
    for axis, joint in enumerate(joints):
        if np.isfinite(chain.period[joint]):
            ends = np.stack([np.take(numbers, 0, axis), np.take(numbers, -1, axis)], axis=-1).reshape(-1, 2)
            links.append(ends[(ends > 0).all(axis=1)] - 1)
    return _pieces(np.concatenate(links), count)


def _pieces(links: Indices, count: int) -> int:
    """The number of connected components of a graph with `count` nodes."""
    return int(_piece_of(links, count).max()) + 1 if count else 0


def _piece_of(links: Indices, count: int) -> Indices:
    """The number of its connected component, from 0, for each of at least one node."""
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1])


def _linked(chain: ScrewChain, leaf: Leaf, rng: np.random.Generator) -> int:
    """The number of pieces as groups of long walks from samples, linked if a short walk leads from one to the other."""
    values = np.array(leaf.samples[-POINTS:])
    values[:, list(leaf.free)] = leaf.samples[0, list(leaf.free)]
    ends = polish(chain, leaf.pinned(values), leaf.corank)
    clear, dimensions = readable_at(ends.residual)
    values = ends.values[clear & (dimensions == leaf.dimension)]
    if len(values) == 0:
        return 1
    dimensions, count = np.full(len(values), leaf.dimension), len(values)
    places, owner = values, np.arange(count)
    links = np.empty((0, 2), dtype=int)
    for steps in WALKS:
        walked = walk(chain, values, leaf.corank, dimensions, rng, steps=steps, length=LENGTH, resting=leaf.free)
        values = walked.values[:, -1]
        places = np.concatenate([places, walked.values[:, 1:].reshape(-1, chain.n)])
        owner = np.concatenate([owner, np.repeat(np.arange(count), steps)])
        links = _all_links(chain, leaf, places, owner, links)
        if _pieces(links, count) == 1:
            break
    return _pieces(links, count)


def _all_links(chain: ScrewChain, leaf: Leaf, places: Array, owner: Indices, links: Indices) -> Indices:
    """The links between walks, extended until no more are found."""
    near = _near(chain, places)
    for _ in range(ROUNDS):
        piece = _piece_of(links, int(owner.max()) + 1)[owner]
        near = near[piece[near[:, 0]] != piece[near[:, 1]]]
        pairs = _closest(chain, places, piece, near)
        if len(pairs) == 0:
            break
        reached = _reached(chain, leaf, places[pairs[:, 0]], places[pairs[:, 1]])
        if not reached.any():
            break
        links = np.concatenate([links, owner[pairs[reached]]])
    return links


def _near(chain: ScrewChain, places: Array) -> Indices:
    """All pairs of places that are near each other, (P, 2)."""
    around = np.where(np.isfinite(chain.period), chain.period, 1e9)
    tree = cKDTree(np.mod(places, around), boxsize=np.nextafter(around, np.inf))
    return np.asarray(tree.query_pairs(NEAR, output_type="ndarray"))


def _closest(chain: ScrewChain, places: Array, piece: Indices, near: Indices) -> Indices:
    """For each two pieces that come near each other their closest places, (P, 2).

    Args:
        chain: What moves the tip.
        places: Joint values, (N, n).
        piece: The piece of each place, (N,).
        near: Pairs of places of different pieces, (M, 2).
    """
    apart = np.linalg.norm(wrapped(places[near[:, 0]] - places[near[:, 1]], chain.period), axis=1)
    pairs = near[np.argsort(apart)]
    _, first = np.unique(np.sort(piece[pairs], axis=1), axis=0, return_index=True)
    return np.asarray(pairs[first])


def _reached(chain: ScrewChain, leaf: Leaf, start: Array, goal: Array) -> Array:
    """Whether walks along the stratum that head for their goals reach them."""
    here, at = start.copy(), Residual.at(chain, start, leaf.corank)
    alive = np.ones(len(start), dtype=bool)
    for _ in range(STEPS):
        to_go = wrapped(goal - here, chain.period)
        active = np.flatnonzero(alive & (np.linalg.norm(to_go, axis=1) > STEP))
        if active.size == 0:
            break
        P = tangents_at(at.select(active), np.full(len(active), leaf.dimension))
        along = (P @ to_go[active][..., None])[..., 0]
        size = np.linalg.norm(along, axis=1, keepdims=True)
        predicted = here[active] + STEP * along / np.maximum(size, 1e-9)
        ends = polish(chain, predicted, leaf.corank)
        good = (np.linalg.norm(ends.values - predicted, axis=1) <= REFUSED * STEP) & (size[:, 0] > 0.05 * STEP)
        here[active[good]] = ends.values[good]
        at.put(active[good], ends.residual.select(np.flatnonzero(good)))
        alive[active[~good]] = False
    return np.asarray(np.linalg.norm(wrapped(goal - here, chain.period), axis=1) <= STEP)
