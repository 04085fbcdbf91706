"""Draws wrench screws: a long thin line for a force, a ring for a couple, both for a screw with pitch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.display.scene.animation_tracks import Still, Tracks
from robust_ik.display.scene.meshcat_module import Visualizer, geometry
from robust_ik.display.scene.primitives import (
    BOTH_SIDES,
    Color,
    TriangleGeometry,
    double_arrow,
    material,
    turning_ring,
)
from robust_ik.display.scene.smooth_motion import carried_frames

WRENCH: Color = (0.45, 0.27, 0.78, 1.0)
LINE, RING = 4.0, 1.25
"""Half-length of a line and radius of a couple's ring, in units of the marks' size."""
FORCE = 1e-5
"""A pitch below this, in units of the marks' size, counts as zero."""
FAR = 20.0
"""A line farther than this from the tip, in units of the marks' size, counts as a couple."""


@dataclass(frozen=True, eq=False)
class Wrenches:
    """Wrench screws over time.

    Attributes:
        axes: Unit directions in the world, zero for no wrench, (N, k, 3).
        points: The points of the axes that are nearest to the tip, m; the tip for couples, (N, k, 3).
        forces: Magnitudes of the forces, of wrenches with ‖(force, moment)‖ = 1, (N, k).
        pitches: Moment along the axis over force, m/rad; infinite for couples, (N, k).
    """

    axes: Array
    points: Array
    forces: Array
    pitches: Array

    @classmethod
    def of(cls, twists: Array, tip: Array, size: float) -> Wrenches:
        """The screws of the wrenches that have the six numbers of lost twists.

        Args:
            twists: Force, then moment about the tip, world axes, (N, 6, k).
            tip: Tip positions, (N, 3), m.
            size: Size of the marks, m, which is the unit of FORCE and FAR.
        """
        force, moment = np.swapaxes(twists[:, :3], 1, 2), np.swapaxes(twists[:, 3:], 1, 2)
        strength = np.linalg.norm(force, axis=-1, keepdims=True)
        safe = np.maximum(strength, 1e-12)
        away = np.cross(force, moment) / safe**2
        couple = (strength < 1e-12) | (np.linalg.norm(away, axis=-1, keepdims=True) > FAR * size)
        axes = np.where(couple, moment, force)
        axes = axes / np.maximum(np.linalg.norm(axes, axis=-1, keepdims=True), 1e-12)
        pitches = np.sum(force * moment, axis=-1) / safe[..., 0] ** 2
        return cls(
            axes=axes,
            points=tip[:, None] + np.where(couple, 0.0, away),
            forces=np.where(couple, 0.0, strength)[..., 0],
            pitches=np.where(couple[..., 0], np.inf, pitches),
        )

    @property
    def count(self) -> int:
        """Number of wrenches."""
        return int(self.axes.shape[1])


def draw_wrenches(visualizer: Visualizer, count: int) -> None:
    """Draws lines and rings for `count` wrenches, hidden until they are animated or placed."""
    solid = material(WRENCH, side=BOTH_SIDES, emissive=0x241044)
    ghost = material((*WRENCH[:3], 0.35), side=BOTH_SIDES, emissive=0x241044, depthTest=False)
    shapes = {"line": double_arrow(0.0045, 0.018, 0.06), "ring": turning_ring(0.02, 0.08)}
    for name, triangles in shapes.items():
        for index in range(count):
            node = visualizer[f"{name}{index}"]
            node["solid"].set_object(geometry.Mesh(TriangleGeometry(triangles), solid))
            node["ghost"].set_object(geometry.Mesh(TriangleGeometry(triangles), ghost))
            node.set_property("visible", False)


def animate_wrenches(
    tracks: Tracks | Still, visualizer: Visualizer, count: int, wrenches: Wrenches, size: float
) -> None:
    """Animates lines on the screws' axes, and rings about the axes of those with a moment along them."""
    none = np.zeros(len(wrenches.axes), dtype=bool)
    for index in range(count):
        line, ring = visualizer[f"line{index}"], visualizer[f"ring{index}"]
        if index >= wrenches.count:
            tracks.visible(line, none)
            tracks.visible(ring, none)
            continue
        force, pitch = wrenches.forces[:, index] > 0, wrenches.pitches[:, index]
        frames = carried_frames(wrenches.axes[:, index])
        turning = np.abs(pitch) > FORCE * size
        # The ring of a line shows its pitch: the larger the ring, the more it is like a couple.
        share = np.where(force, np.clip(np.abs(np.where(force, pitch, 0.0)) / size, 0.2, 1.0), RING)
        for node, factor in ((line, np.full(len(share), LINE)), (ring, share)):
            tracks.position(node, wrenches.points[:, index])
            tracks.turn(node, frames)
            tracks.size(node, factor * size)
        tracks.visible(line, force)
        tracks.visible(ring, turning)
