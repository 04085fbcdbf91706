"""Coal, wrapped in one place: solids, and the distance between two of them. The only module that imports it."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple, TypeAlias

import coal
import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array
from robust_ik.control.limits.obstacles import HalfSpace
from robust_ik.description.joint_tree import Box, Cylinder, Sphere

LEAST_SIZE = 1e-6
"""Least side or radius, m: a URDF may state zero."""
LEAST_THICKNESS = 1e-4
"""Half of the thickness that is added to a flat mesh, m."""
DIRECTIONS = 250
"""Most corners of a hull that had too many edges at one corner: coal accepts at most 255 edges."""
ITERATIONS = 128
"""Most iterations of coal's search for a depth (EPA); its default is 64.

Chosen: more give more exact depths, but take longer.
"""
TOLERANCE = 1e-8
"""Relative accuracy of coal's distances between round shapes; normals are only as accurate as its root."""
UNIT_TOLERANCE = 1e-6
"""Largest difference of a normal's squared length from 1.

Chosen: far above rounding; where coal fails it is 0 or NaN.
"""


Transform: TypeAlias = Any
"""A pose as coal's type; `a * b` is b's pose in the frame that has the pose a."""


class Contact(NamedTuple):
    """The closest points of two solids, or the deepest ones if one is inside the other.

    distance = normal · (point_b − point_a) is negative if one is inside the other, and grows as b moves along the
    normal.

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
        solid: The solid, as a shape of coal.
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

    Flat ones are made 0.2 mm thick. If a corner has more edges than coal accepts, like the tip of a fine cone, some
    corners are left out, and the solid is enlarged by the distance that they stick out.
    """
    # Not coal's own hull: it ends the process on flat points.
    from scipy.spatial import ConvexHull, QhullError  # slow to import: only if a mesh is read

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
    """Directions, (DIRECTIONS, 3), spread evenly on a spiral."""
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


def placed(pose: Array) -> Transform:
    """A pose (4, 4) as coal's type."""
    return coal.Transform3s(pose[:3, :3], pose[:3, 3])


def contact(a: Geometry, pose_a: Transform, b: Geometry, pose_b: Transform) -> Contact:
    """The contact of two placed solids; if coal finds no usable one, that of their bounding spheres.

    Args:
        a: Any solid except a half space.
        pose_a: Of `a`, from `placed`.
        b: Any solid.
        pose_b: Of `b`, from `placed`.
    """
    found = near_contact(a, pose_a, b, pose_b, math.inf)
    return found if isinstance(found, Contact) else _of_spheres(a, pose_a, b, pose_b)


def near_contact(a: Geometry, pose_a: Transform, b: Geometry, pose_b: Transform, within: float) -> Contact | float:
    """As `contact`, but of solids that are not nearer than `within` the distance alone, which is quicker."""
    request, result = _SCRATCH.request, _SCRATCH.result
    result.clear()
    try:
        coal.distance(a.solid, pose_a, b.solid, pose_b, request, result)
    except (RuntimeError, ValueError):
        return _of_spheres(a, pose_a, b, pose_b)
    distance = float(result.min_distance)
    if within <= distance < math.inf:
        return distance
    normal, point_a, point_b = result.normal.copy(), result.getNearestPoint1(), result.getNearestPoint2()  # all copies
    x, y, z = normal.tolist()
    finite = math.isfinite(distance + sum(point_a.tolist()) + sum(point_b.tolist()))
    if not (finite and abs(x * x + y * y + z * z - 1) < UNIT_TOLERANCE):  # written so that NaN is not usable
        return _of_spheres(a, pose_a, b, pose_b)
    return Contact(distance, normal, point_a, point_b)


def _of_spheres(a: Geometry, pose_a: Transform, b: Geometry, pose_b: Transform) -> Contact:
    """The contact of the bounding spheres: their distance is at most that of the solids."""
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
