"""Coal, wrapped once: solids, and the distance between two of them. The only place that imports it."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import coal
import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.limits.obstacles import HalfSpace
from robust_ik.description.joint_tree import Box, Cylinder, Sphere

LEAST_SIZE = 1e-6
"""Sides and radii are at least this, m: a URDF may state zero."""
LEAST_THICKNESS = 1e-4
"""Half of what a flat mesh is thickened by, m."""
DIRECTIONS = 250
"""Corners of a hull that had too many edges at one; coal takes 255 edges."""
ITERATIONS = 128
"""Of coal's search for a depth (EPA), whose default is 64. Chosen: more make depths more exact, and take longer."""
TOLERANCE = 1e-8
"""Of coal's distances between round shapes, relative; normals are as exact as its root."""
UNIT_TOLERANCE = 1e-6
"""How far a normal's squared length may be from 1. Chosen: far above rounding; where coal fails it is 0 or NaN."""


class Contact(NamedTuple):
    """Where two solids are nearest to each other, or deepest inside each other.

    distance = normal · (point_b − point_a) is negative for the latter, and grows as b moves along the normal.

    Attributes:
        distance: m.
        normal: Unit vector from a to b, (3,).
        point_a: On the surface of a, (3,), m.
        point_b: On the surface of b, (3,), m.
    """

    distance: float
    normal: Array
    point_a: Array
    point_b: Array


@dataclass(frozen=True, eq=False)
class Geometry:
    """A convex solid with a sphere around it.

    Attributes:
        solid: Coal's.
        center: Of the sphere, (3,), m.
        radius: Of the sphere, m; infinite for a half space.
        plane: For a half space its normal and offset, (4,); else None.
    """

    solid: Any
    center: Array
    radius: float
    plane: Array | None = None


def primitive(shape: Box | Sphere | Cylinder | HalfSpace) -> Geometry:
    """The solid of a shape about its own origin."""
    center = np.zeros(3)
    match shape:
        case Box(size):
            sides = np.maximum(size, LEAST_SIZE)
            return Geometry(coal.Box(*sides.tolist()), center, float(np.linalg.norm(sides)) / 2)
        case Sphere(radius):
            radius = max(radius, LEAST_SIZE)
            return Geometry(coal.Sphere(radius), center, radius)
        case Cylinder(radius, length):
            radius, length = max(radius, LEAST_SIZE), max(length, LEAST_SIZE)
            return Geometry(coal.Cylinder(radius, length), center, math.hypot(radius, length / 2))
        case HalfSpace(normal, offset):
            solid = coal.Halfspace(np.array(normal), offset)
            return Geometry(solid, np.array(normal) * offset, math.inf, np.array([*normal, offset]))


def convex_hull(points: Array) -> Geometry:
    """The convex hull of points (V, 3).

    Flat ones are made 0.2 mm thick. Where a corner has more edges than coal can take, as the tip of a fine cone has,
    some corners are left out and the solid is grown by what they stick out.
    """
    # Not coal's own hull: on flat points it ends the process.
    from scipy.spatial import ConvexHull, QhullError  # takes a while: only where a mesh is read

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        thickness = max(LEAST_THICKNESS, 1e-6 * float(np.abs(points).max()))
        corners = np.array(list(product((-thickness, thickness), repeat=3)))
        hull = ConvexHull((np.unique(points, axis=0)[:, None] + corners).reshape(-1, 3))
    try:
        return _convex(hull.points, hull.simplices)
    except RuntimeError:
        points = hull.points[hull.vertices]
        few = points[np.unique(np.argmax(points @ _directions().T, axis=0))]
        coarse = _convex(few, ConvexHull(few).simplices)
    dot = primitive(Sphere(LEAST_SIZE))
    outside = (contact(dot, placed(_shifted(point)), coarse, placed(np.eye(4))).distance for point in points)
    margin = max(outside) + 2 * LEAST_SIZE
    coarse.solid.setSweptSphereRadius(margin)
    return Geometry(coarse.solid, coarse.center, coarse.radius + margin)


def _convex(points: Array, triangles: NDArray[np.int_]) -> Geometry:
    """The polyhedron of those triangles of points."""
    used, corners = np.unique(triangles, return_inverse=True)
    vertices, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for vertex in points[used]:
        vertices.append(vertex)
    for a, b, c in corners.reshape(-1, 3).tolist():
        faces.append(coal.Triangle(a, b, c))
    center = (points[used].max(axis=0) + points[used].min(axis=0)) / 2
    radius = float(np.linalg.norm(points[used] - center, axis=1).max())
    return Geometry(coal.Convex(vertices, faces), center, radius)


def _directions() -> Array:
    """Directions spread evenly, (DIRECTIONS, 3), on a spiral."""
    height = 1 - 2 * (np.arange(DIRECTIONS) + 0.5) / DIRECTIONS
    turn = np.pi * (1 + math.sqrt(5)) * np.arange(DIRECTIONS)
    flat = np.sqrt(1 - height**2)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), height], axis=-1)


def _shifted(point: Array) -> Array:
    T = np.eye(4)
    T[:3, 3] = point
    return T


class _Scratch(threading.local):
    """Coal's request and result, one per thread."""

    def __init__(self) -> None:
        self.request = coal.DistanceRequest()
        self.request.enable_signed_distance = True
        self.request.gjk_tolerance = TOLERANCE
        self.request.epa_max_iterations = ITERATIONS
        self.result = coal.DistanceResult()


_SCRATCH = _Scratch()


def placed(pose: Array) -> Any:
    """A pose (4, 4) as coal takes it."""
    return coal.Transform3s(pose[:3, :3], pose[:3, 3])


def contact(a: Geometry, pose_a: Any, b: Geometry, pose_b: Any) -> Contact:
    """Where two placed solids are nearest; where coal finds nothing usable, what their spheres say.

    Args:
        a: No half space.
        pose_a: Of `a`, as `placed` gives it.
        b: Any solid.
        pose_b: Of `b`.
    """
    request, result = _SCRATCH.request, _SCRATCH.result
    result.clear()
    try:
        coal.distance(a.solid, pose_a, b.solid, pose_b, request, result)
    except (RuntimeError, ValueError):
        return _of_spheres(a, pose_a, b, pose_b)
    normal, point_a, point_b = (
        np.array(each) for each in (result.normal, result.getNearestPoint1(), result.getNearestPoint2())
    )
    distance = float(result.min_distance)
    usable = math.isfinite(distance + point_a @ point_a + point_b @ point_b)
    if not (usable and abs(normal @ normal - 1) < UNIT_TOLERANCE):  # written so that NaN is not usable
        return _of_spheres(a, pose_a, b, pose_b)
    return Contact(distance, normal, point_a, point_b)


def _of_spheres(a: Geometry, pose_a: Any, b: Geometry, pose_b: Any) -> Contact:
    """The contact of the spheres around two solids: never further apart than these."""
    center_a = np.array(pose_a.transform(a.center))
    if b.plane is not None:
        normal = -np.array(pose_b.getRotation()) @ b.plane[:3]
        gap = float(normal @ (np.array(pose_b.transform(b.center)) - center_a))
        return Contact(gap - a.radius, normal, center_a + a.radius * normal, center_a + gap * normal)
    apart = np.array(pose_b.transform(b.center)) - center_a
    length = float(np.linalg.norm(apart))
    normal = apart / length if length > 0 else np.array([0.0, 0.0, 1.0])
    point_a, point_b = center_a + a.radius * normal, center_a + (length - b.radius) * normal
    return Contact(length - a.radius - b.radius, normal, point_a, point_b)
