"""Triangle meshes: joined, thinned, and split at sharp edges. Arrays only, except for trimesh's adjacency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

MAX_FACES = 25_000
"""Most triangles of a drawn mesh. Chosen: they take 0.5 MB of a page; more show finer details, but load more slowly."""
CREASE = np.radians(35.0)
"""Edges with a larger angle are drawn sharp.

Chosen: cylinders of 11 sides or more look round, chamfers of 45° do not.
"""
MATCHED_EDGES = 0.995
"""Fraction of edges with faces on both sides that makes a mesh closed. Chosen: a few flaws pass, a hole does not."""


@dataclass(frozen=True, eq=False)
class Triangles:
    """Vertices, faces, and perhaps colours.

    Attributes:
        vertices: (V, 3), m.
        faces: Indices of corners, (F, 3).
        colors: RGB of the vertices, (V, 3), or None.
        closed: Whether it encloses a volume, so that its inside cannot be seen.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    colors: NDArray[np.uint8] | None = None
    closed: bool = False

    @classmethod
    def of(cls, vertices: ArrayLike, faces: ArrayLike, colors: NDArray[np.uint8] | None = None) -> Self:
        """From arrays of any number type."""
        return cls(np.asarray(vertices, np.float32), np.asarray(faces, np.uint32).reshape(-1, 3), colors)

    @classmethod
    def joined(cls, pieces: Sequence[Triangles]) -> Self:
        """Several meshes as one; with colours only if all have them."""
        offsets = np.cumsum([0, *(len(piece.vertices) for piece in pieces)])
        colors = [piece.colors for piece in pieces if piece.colors is not None]
        return cls(
            np.concatenate([piece.vertices for piece in pieces]),
            np.concatenate([piece.faces + np.uint32(offset) for piece, offset in zip(pieces, offsets)]),
            np.concatenate(colors) if len(colors) == len(pieces) else None,
        )

    @property
    def bounds(self) -> NDArray[np.float32]:
        """Least and greatest coordinates, (2, 3)."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])


def tidy(mesh: Triangles, max_faces: int = MAX_FACES) -> Triangles:
    """The same shape for smooth shading: corners merged, faces limited to `max_faces`, sharp edges split."""
    mesh = _finite(mesh)
    if len(mesh.faces) <= 4 * max_faces:  # otherwise all corners are merged in cells below
        mesh = _merged(mesh)
    if len(mesh.faces) > max_faces:
        mesh = _thinned(mesh, max_faces)
    return replace(_split_at_creases(mesh), closed=_is_closed(mesh))


def _is_closed(mesh: Triangles) -> bool:
    """Whether almost every edge is used in both directions, and the enclosed volume is positive."""
    if len(mesh.faces) == 0:
        return False
    faces = mesh.faces.astype(np.int64)
    ends = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    matched = np.isin(ends[:, 0] * len(mesh.vertices) + ends[:, 1], ends[:, 1] * len(mesh.vertices) + ends[:, 0])
    return bool(matched.mean() > MATCHED_EDGES) and signed_volume(mesh) > 0


def signed_volume(mesh: Triangles) -> float:
    """The enclosed volume, m³; negative if the faces point inwards."""
    a, b, c = np.moveaxis(mesh.vertices.astype(float)[mesh.faces], 1, 0)
    return float(np.einsum("fi,fi->", a, np.cross(b, c)) / 6)


def _finite(mesh: Triangles) -> Triangles:
    good: NDArray[np.bool_] = np.asarray(np.isfinite(mesh.vertices).all(axis=1))
    vertices = np.where(good[:, None], mesh.vertices, np.float32(0))
    return Triangles(vertices, mesh.faces[good[mesh.faces].all(axis=1)], mesh.colors)


def _merged(mesh: Triangles, cell: float = 0.0) -> Triangles:
    """Merges vertices at the same place, or in the same cell of this size, and drops faces that collapse."""
    if len(mesh.faces) == 0:
        return mesh
    used = mesh.vertices[mesh.faces.ravel()]
    _, first, inverse = np.unique(_keys(used, cell), return_index=True, return_inverse=True)
    faces = inverse.reshape(-1, 3).astype(np.uint32)
    distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    colors = None if mesh.colors is None else mesh.colors[mesh.faces.ravel()][first]
    return Triangles(used[first], faces[distinct], colors)


def _keys(points: NDArray[np.float32], cell: float) -> NDArray[np.int64]:
    """An integer for each point, equal within one cell, or for cell 0 at one place: integers sort fast."""
    if cell > 0:
        places = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
        x, y, z = np.ascontiguousarray(np.minimum(places, 2**20).T)
        return np.asarray((x << 42) | (y << 21) | z)
    x, y, z = np.ascontiguousarray((points + np.float32(0)).view(np.uint32).T).astype(np.uint64)  # + 0 turns −0 into 0
    mixed = (x << np.uint64(32) | y) * np.uint64(0x9E3779B97F4A7C15)
    mixed = ((mixed ^ (mixed >> np.uint64(29))) + z) * np.uint64(0xBF58476D1CE4E5B9)
    keys = (mixed ^ (mixed >> np.uint64(32))).view(np.int64)
    order = np.argsort(keys, kind="stable")
    same = np.diff(keys[order]) == 0
    if not (points[order[1:]][same] == points[order[:-1]][same]).all():  # two places have the same integer
        _, keys = np.unique(points + np.float32(0), axis=0, return_inverse=True)
    return np.asarray(keys).reshape(-1)


def _thinned(mesh: Triangles, max_faces: int) -> Triangles:
    """Merges vertices in ever larger cells until there are few enough faces."""
    size = float(np.linalg.norm(mesh.bounds[1] - mesh.bounds[0]))
    cells = 400.0
    while len(mesh.faces) > max_faces and cells > 10:
        mesh = _merged(mesh, size / cells)
        mesh = Triangles(mesh.vertices, _without_copies(mesh.faces), mesh.colors)
        # The number of faces falls with the square of the cell size: far above the goal steps are larger.
        cells *= min(0.8, max(0.4, 1.2 * (max_faces / max(len(mesh.faces), 1)) ** 0.5))
    return mesh


def _without_copies(faces: NDArray[np.uint32]) -> NDArray[np.uint32]:
    a, b, c = np.sort(faces, axis=1).astype(np.int64).T
    _, pair = np.unique(a * (int(faces.max(initial=0)) + 1) + b, return_inverse=True)
    _, first = np.unique(pair * (int(faces.max(initial=0)) + 1) + c, return_index=True)
    return faces[np.sort(first)]


def _split_at_creases(mesh: Triangles, angle: float = float(CREASE)) -> Triangles:
    """Gives each smooth patch at a corner a vertex of its own: no normal is averaged over a sharp edge."""
    if len(mesh.faces) == 0:
        return mesh
    import trimesh  # takes half a second: imported only if a mesh is read

    shape: Any = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    smooth = shape.face_adjacency[shape.face_adjacency_angles < angle]
    patch = trimesh.graph.connected_component_labels(smooth, node_count=len(mesh.faces))
    keys = (patch[:, None].astype(np.int64) * len(mesh.vertices) + mesh.faces).ravel()
    unique, inverse = np.unique(keys, return_inverse=True)
    origin = unique % len(mesh.vertices)
    colors = None if mesh.colors is None else mesh.colors[origin]
    return Triangles(mesh.vertices[origin], inverse.reshape(-1, 3).astype(np.uint32), colors)
