"""Shapes that MeshCat lacks: light triangle meshes, solid arrows, rings, tubes, grids."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.description.meshes import Triangles
from robust_ik.display.scene.meshcat_module import EXTENSION, geometry, umsgpack
from robust_ik.display.scene.smooth_motion import carried_frames

Color = tuple[float, float, float, float]
GREY: Color = (0.72, 0.74, 0.77, 1.0)
FRONT, BOTH_SIDES = 0, 2
"""three.js's codes. The inside of a closed surface is never seen, but flickers where two surfaces touch."""

if TYPE_CHECKING:
    _Geometry: Any = object
else:
    _Geometry = geometry.Geometry


class TriangleGeometry(_Geometry):  # type: ignore[misc]
    """Triangles for three.js, with 16-bit indices and 8-bit colours if they are enough."""

    def __init__(self, triangles: Triangles) -> None:
        super().__init__()
        self.triangles = triangles

    def lower(self, _: Any) -> dict[str, Any]:
        """The description for the viewer."""
        mesh = self.triangles
        small = len(mesh.vertices) < 1 << 16
        attributes = {"position": _typed(mesh.vertices.astype(np.float32), 3)}
        if mesh.colors is not None:
            attributes["color"] = _typed(mesh.colors, 3) | {"normalized": True}
        index = _typed(mesh.faces.astype(np.uint16 if small else np.uint32).ravel(), 1)
        return {"uuid": self.uuid, "type": "BufferGeometry", "data": {"attributes": attributes, "index": index}}


def _typed(array: NDArray[Any], size: int) -> dict[str, Any]:
    name = {"uint8": "Uint8Array", "uint16": "Uint16Array", "uint32": "Uint32Array", "float32": "Float32Array"}
    return {"itemSize": size, "type": name[array.dtype.name], "array": packed_array(array), "normalized": False}


def packed_array(array: NDArray[Any]) -> Any:
    """An array in C order that the viewer unpacks as a typed array."""
    return umsgpack.Ext(EXTENSION[array.dtype.name], np.ascontiguousarray(array).tobytes())


def triangle_mesh(triangles: Triangles, color: Color | None, **properties: Any) -> Any:
    """Triangles with a material: of one colour, or without one of the vertices' colours, if there are any."""
    by_vertex = color is None and triangles.colors is not None
    chosen = (1.0, 1.0, 1.0, 1.0) if by_vertex else color or GREY
    look = {"vertexColors": by_vertex, "side": FRONT if triangles.closed else BOTH_SIDES} | properties
    return geometry.Mesh(TriangleGeometry(triangles), material(chosen, **look))


def material(color: Color, **properties: Any) -> Any:
    """A matt material; opacity below one makes it transparent."""
    red, green, blue, alpha = (min(max(channel, 0.0), 1.0) for channel in color)
    number = round(255 * red) << 16 | round(255 * green) << 8 | round(255 * blue)
    calm = {"specular": 0x0A0A0A, "shininess": 12, "side": FRONT}
    seen_through = {"opacity": alpha, "transparent": True, "depthWrite": False} if alpha < 1 else {}
    return geometry.MeshPhongMaterial(color=number, **(calm | seen_through | properties))


# ---------------------------------------------------------------------------------------------- solids
def revolved(profile: Array, sides: int = 24) -> Triangles:
    """The solid of revolution of a profile (P, 2) of radius and height about z; radius 0 at both ends closes it."""
    angles = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    rings = [
        np.column_stack([radius * circle, np.full(sides, height)]) for radius, height in np.asarray(profile, float)
    ]
    # Every strip has vertices of its own, so that the edges between strips stay sharp.
    strips = [Triangles.of(np.concatenate(pair), _strip(2, sides)) for pair in itertools.pairwise(rings)]
    return Triangles.joined(strips)


def _strip(rings: int, sides: int) -> NDArray[np.int64]:
    """Faces between consecutive rings of `sides` vertices."""
    a = np.arange(rings - 1)[:, None] * sides + np.arange(sides)
    b = np.arange(rings - 1)[:, None] * sides + (np.arange(sides) + 1) % sides
    quads = np.stack([a, b, b + sides, a, b + sides, a + sides], axis=-1)
    return np.asarray(quads.reshape(-1, 3))


def double_arrow(shaft: float = 0.035, head: float = 0.1, tip: float = 0.28) -> Triangles:
    """A solid arrow along z from −1 to 1 with a head at either end."""
    half = [(shaft, 0.0), (shaft, 1 - tip), (head, 1 - tip), (0.0, 1.0)]
    mirrored = [(radius, -height) for radius, height in reversed(half[1:])]
    return revolved(np.array([*mirrored, *half[1:]]))


def turning_ring(tube: float = 0.042, head: float = 0.13, gap: float = 0.9) -> Triangles:
    """A ring of radius 1 about z, open by `gap` rad, with an arrow head at either end, and its axis, dashed."""
    angles = np.linspace(gap / 2, 2 * np.pi - gap / 2, 49)
    path = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=-1)
    pieces = [swept_tube(path, tube, sides=12)]
    for angle, sign in ((angles[0], -1.0), (angles[-1], 1.0)):
        along = sign * np.array([-np.sin(angle), np.cos(angle), 0.0])
        cone = revolved(np.array([(0.0, 0.0), (head, 0.0), (0.0, 2.4 * head)]))
        pieces.append(_placed(cone, carried_frames(along[None])[0], np.array([np.cos(angle), np.sin(angle), 0])))
    for height in (-0.95, -0.65, 0.65, 0.95):
        dash = revolved(np.array([(0.0, -0.09), (0.6 * tube, -0.09), (0.6 * tube, 0.09), (0.0, 0.09)]), sides=10)
        pieces.append(_placed(dash, np.eye(3), np.array([0.0, 0.0, height])))
    return Triangles.joined(pieces)


def _placed(mesh: Triangles, rotation: Array, shift: Array) -> Triangles:
    return Triangles.of(mesh.vertices @ rotation.T + shift, mesh.faces)


def swept_tube(points: Array, radius: float, sides: int = 6) -> Triangles:
    """A tube along a polyline (P, 3); its faces are in the order of the points, so that a part of it can be drawn."""
    points = np.asarray(points, dtype=float)
    tangents = np.gradient(points, axis=0) if len(points) > 1 else np.zeros_like(points)
    frames = carried_frames(tangents)
    angles = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
    circle = radius * (np.cos(angles)[:, None] * [1.0, 0, 0] + np.sin(angles)[:, None] * [0, 1.0, 0])
    vertices = points[:, None, :] + np.einsum("pij,sj->psi", frames, circle)
    return Triangles.of(vertices.reshape(-1, 3), _strip(len(points), sides))


def rod(start: Array, end: Array, radius: float, sides: int = 16) -> Triangles:
    """A closed cylinder between two points."""
    along = np.asarray(end, float) - start
    length = float(np.linalg.norm(along))
    solid = revolved(np.array([(0.0, 0.0), (radius, 0.0), (radius, length), (0.0, length)]), sides)
    return _placed(solid, carried_frames(along[None])[0], np.asarray(start, float))


# ---------------------------------------------------------------------------------------------- lines
def line_segments(points: Array, color: int, opacity: float = 1.0) -> Any:
    """Thin lines between points 0-1, 2-3 …, (2 k, 3)."""
    look = geometry.LineBasicMaterial(color=color, opacity=opacity, transparent=opacity < 1)
    return geometry.LineSegments(geometry.PointsGeometry(np.asarray(points, np.float32).T), look)


def grid(half_size: float, step: float) -> Array:
    """Line segments of a square grid in the plane z = 0, for `line_segments`."""
    count = max(1, round(half_size / step))
    ticks, end = step * np.arange(-count, count + 1), step * count
    lines = [((tick, -end, 0.0), (tick, end, 0.0)) for tick in ticks]
    across = [((y0, x0, 0.0), (y1, x1, 0.0)) for (x0, y0, _), (x1, y1, _) in lines]
    return np.array([*lines, *across]).reshape(-1, 3)


def great_circles(count: int = 64) -> Array:
    """Line segments of the three main circles of the unit sphere, for `line_segments`."""
    angles = np.linspace(0.0, 2 * np.pi, count + 1)
    flat = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=-1)
    circles = [np.roll(flat, shift, axis=-1) for shift in range(3)]
    return np.concatenate([np.stack([c[:-1], c[1:]], axis=1).reshape(-1, 3) for c in circles])
