"""Marks beside a robot: lost directions, the manipulability ellipsoid, target, trail."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robust_ik.checks import Array, checked_parameter
from robust_ik.description.meshes import Triangles
from robust_ik.display.scene.animation_tracks import LARGEST, Still, Tracks
from robust_ik.display.scene.meshcat_module import Visualizer, geometry
from robust_ik.display.scene.primitives import (
    BOTH_SIDES,
    Color,
    TriangleGeometry,
    double_arrow,
    great_circles,
    line_segments,
    material,
    rod,
    swept_tube,
    triangle_mesh,
    turning_ring,
)
from robust_ik.display.scene.smooth_motion import carried_frames, follow, right_handed
from robust_ik.kinematics.twist_rows import ROWS

LOST: Color = (0.88, 0.12, 0.22, 1.0)
ELLIPSOID: Color = (0.15, 0.55, 0.75, 0.22)
TARGET: Color = (0.15, 0.62, 0.30, 1.0)
AXES: tuple[Color, ...] = ((0.85, 0.2, 0.2, 1.0), (0.2, 0.65, 0.2, 1.0), (0.2, 0.35, 0.85, 1.0))
GAMMA = 0.1
"""A direction counts as being lost below σ = GAMMA σ₁, J-PARSE's default."""

FAINTEST = 0.1
"""A mark smaller than this fraction of full size is not drawn."""

SMALLEST_PART = 0.05
"""Nor is a mark for a smaller part of the unit direction than this."""


# ---------------------------------------------------------------------------------------- lost directions
@dataclass(frozen=True, eq=False)
class LostDirections:
    """Task directions over time, and how close each is to being lost.

    Attributes:
        linear: Translation part of the directions, (N, k, 3).
        angular: Rotation part, (N, k, 3).
        nearness: From 0 at σ = gamma σ₁ to 1 at σ = 0, (N, k).
    """

    linear: Array
    angular: Array
    nearness: Array

    @classmethod
    def of(cls, J: Array, rows: tuple[str, ...], gamma: float = GAMMA) -> LostDirections:
        """The directions that are being lost at some time, for Jacobians (N, len(rows), n)."""
        gamma = checked_parameter("gamma", gamma, above=0)
        U, s = follow(J)
        largest = np.maximum(s.max(axis=1, keepdims=True), np.finfo(float).tiny)
        nearness = np.clip(1 - s / (gamma * largest), 0.0, 1.0)
        ever = (nearness > 0).any(axis=0)
        twists = np.zeros((len(J), int(ever.sum()), 6))
        twists[..., [ROWS.index(row) for row in rows]] = np.swapaxes(U[:, :, ever], 1, 2)
        return cls(twists[..., :3], twists[..., 3:], nearness[:, ever])

    @property
    def count(self) -> int:
        """Number of directions."""
        return int(self.nearness.shape[1])

    @property
    def spread(self) -> Array:
        """The spread of lost translations as a matrix of unit trace, (3, 3); zero if there are none."""
        weighted = np.einsum("nk,nki,nkj->ij", self.nearness, self.linear, self.linear)
        return np.asarray(weighted / max(float(np.trace(weighted)), np.finfo(float).tiny))


def draw_lost(visualizer: Visualizer, count: int) -> None:
    """Draws arrows and rings for `count` directions, hidden until they are animated or placed.

    Where the robot hides them they are faintly visible.
    """
    solid = material(LOST, side=BOTH_SIDES, emissive=0x5A0812)
    ghost = material((*LOST[:3], 0.3), side=BOTH_SIDES, emissive=0x5A0812, depthTest=False)
    for name, triangles in (("arrow", double_arrow()), ("ring", turning_ring())):
        for index in range(count):
            node = visualizer[f"{name}{index}"]
            node["solid"].set_object(geometry.Mesh(TriangleGeometry(triangles), solid))
            node["ghost"].set_object(geometry.Mesh(TriangleGeometry(triangles), ghost))
            node.set_property("visible", False)


def animate_lost(
    tracks: Tracks | Still, visualizer: Visualizer, count: int, lost: LostDirections, tip: Array, size: float
) -> None:
    """Arrows of half-length `size` at most, and rings of four fifths of that radius, at the tip (N, 3).

    They are smaller for smaller parts of the direction, and for directions farther from being lost.
    """
    for index in range(count):
        for name, parts, share in (("arrow", lost.linear, 1.0), ("ring", lost.angular, 0.8)):
            node = visualizer[f"{name}{index}"]
            if index >= lost.count:
                tracks.visible(node, np.zeros(len(tip), dtype=bool))
                continue
            length = np.linalg.norm(parts[:, index], axis=-1)
            # Roots, so that small parts, and directions that begin to be lost, are visible beside a robot.
            weight = np.sqrt(length * lost.nearness[:, index])
            tracks.position(node, tip)
            tracks.turn(node, carried_frames(np.where(length[:, None] > 1e-3, parts[:, index], 0.0)))
            tracks.size(node, share * size * weight)
            tracks.visible(node, (weight > FAINTEST) & (length > SMALLEST_PART))


# ---------------------------------------------------------------------------------------- ellipsoid
@dataclass(frozen=True, eq=False)
class Ellipsoids:
    """Manipulability ellipsoids over time: the image of ‖q̇‖ = 1 under the rows of translation.

    Attributes:
        axes: Right-handed principal axes as columns, (N, 3, 3).
        lengths: Semi-axes: singular values, zero in directions that are not task rows, (N, 3).
    """

    axes: Array
    lengths: Array

    @classmethod
    def of(cls, J: Array, rows: tuple[str, ...]) -> Ellipsoids | None:
        """The ellipsoids of Jacobians (N, len(rows), n); None without a row of translation. Source: Yoshikawa 1985."""
        linear = [row for row in rows if row in ROWS[:3]]
        if not linear:
            return None
        full = np.zeros((len(J), 3, J.shape[-1]))
        full[:, [ROWS.index(row) for row in linear]] = J[:, [rows.index(row) for row in linear]]
        U, s = follow(full)
        return cls(right_handed(U), s)


def draw_ellipsoid(visualizer: Visualizer) -> None:
    """Draws a transparent unit sphere with its main circles."""
    look = material(ELLIPSOID, side=0, shininess=40, specular=0x303030)
    ball = geometry.Sphere(1.0)
    visualizer["body"].set_object(geometry.Mesh(ball, look))
    visualizer["circles"].set_object(line_segments(great_circles(), 0x1C6E8C, opacity=0.55))


def animate_ellipsoid(
    tracks: Tracks | Still, visualizer: Visualizer, ellipsoids: Ellipsoids, tip: Array, scale: float, thickness: float
) -> None:
    """Animates the ellipsoid at the tip (N, 3): axes `scale` times their lengths, and no thinner than `thickness`."""
    tracks.position(visualizer, tip)
    tracks.turn(visualizer, ellipsoids.axes)
    tracks.size(visualizer, np.maximum(scale * ellipsoids.lengths, thickness))


# ---------------------------------------------------------------------------------------- target and trail
def draw_target(visualizer: Visualizer, size: float) -> None:
    """Draws a small ball with three coloured axes: x red, y green, z blue."""
    visualizer["ball"].set_object(geometry.Mesh(geometry.Sphere(0.22 * size), material((*TARGET[:3], 0.75))))
    for axis, color in enumerate(AXES):
        stick = rod(np.zeros(3), size * np.eye(3)[axis], 0.045 * size)
        visualizer[f"axis{axis}"].set_object(triangle_mesh(stick, color))


def draw_path(visualizer: Visualizer, points: Array, radius: float, color: Color) -> None:
    """Draws a thin tube through points (N, 3)."""
    visualizer.set_object(triangle_mesh(tube(points, radius), color))


def tube(points: Array, radius: float) -> Triangles:
    """A tube with the same number of faces between any two successive points, at least two points."""
    points = np.clip(points, -LARGEST, LARGEST)
    return swept_tube(points if len(points) > 1 else np.repeat(points, 2, axis=0), radius)


def corners_of_path(points: Array) -> NDArray[np.float64]:
    """The points (N, 3) without those equal to the one before."""
    moved = np.concatenate([[True], np.any(np.diff(points, axis=0) != 0, axis=1)])
    return np.asarray(points[moved])
