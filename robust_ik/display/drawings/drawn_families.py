"""Draws families of singular configurations: the robot and its marks once, two animations for each family."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robust_ik.checks import Array
from robust_ik.display.drawings import marks
from robust_ik.display.drawings.drawn_robot import DrawnRobot, draw_robot
from robust_ik.display.drawings.drawn_runs import TRAIL_COLOR
from robust_ik.display.drawings.family_motions import Family, ShownMotion
from robust_ik.display.drawings.marks import LostDirections
from robust_ik.display.drawings.wrenches import Wrenches, animate_wrenches, draw_wrenches
from robust_ik.display.scene.animation_tracks import Tracks
from robust_ik.display.scene.meshcat_module import Visualizer
from robust_ik.display.scene.scene import Scene
from robust_ik.kinematics.svd import svd
from robust_ik.robot.robot import Robot

MARK, TRAIL = 0.28, 0.005
"""Size of marks and thickness of trails, as fractions of the radius of the view."""
LOOKS = 5
"""Number of times in each motion at which the whole robot must be in view."""


@dataclass(frozen=True, eq=False)
class DrawnMotion:
    """A motion in a scene.

    Attributes:
        motion: The motion.
        animation: The animation of robot and marks.
        trail: The node of the tip's path, hidden.
    """

    motion: ShownMotion
    animation: Tracks
    trail: Visualizer


@dataclass(frozen=True, eq=False)
class DrawnFamilies:
    """Families in a scene.

    Attributes:
        robot: The robot.
        walks: Motions through each family.
        sways: Motions out of each family.
        groups: Nodes of the marks that can be hidden, by kind: lost, wrench, trail.
    """

    robot: DrawnRobot
    walks: tuple[DrawnMotion, ...]
    sways: tuple[DrawnMotion, ...]
    groups: dict[str, Visualizer]


def draw_families(scene: Scene, robot: Robot, shown: Sequence[Family]) -> DrawnFamilies:
    """Draws families of one robot, without starting an animation.

    Args:
        scene: The scene; earlier drawings are removed.
        robot: The robot.
        shown: The families; if there are none, the robot is drawn at rest.
    """
    scene.clear()
    start = robot.configuration(shown[0].walk.values[0]) if shown else robot.rest
    drawn = draw_robot(scene["robot"], robot, start)
    size = _place_camera(scene, drawn, [motion for each in shown for motion in (each.walk, each.sway)])
    groups = {kind: scene[kind] for kind in ("lost", "wrench", "trail")}
    count = max((each.stratum.corank for each in shown), default=0)
    marks.draw_lost(groups["lost"], count)
    draw_wrenches(groups["wrench"], count)

    def put(kind: str, index: int, motion: ShownMotion) -> DrawnMotion:
        trail = groups["trail"][f"{kind}{index}"]
        marks.draw_path(trail, motion.tip, TRAIL * size, TRAIL_COLOR)
        trail.set_property("visible", False)
        return DrawnMotion(motion, _animated(drawn, groups, motion, count, MARK * size), trail)

    walks = tuple(put("walk", index, each.walk) for index, each in enumerate(shown))
    sways = tuple(put("sway", index, each.sway) for index, each in enumerate(shown))
    return DrawnFamilies(drawn, walks, sways, groups)


def _animated(robot: DrawnRobot, groups: dict[str, Visualizer], motion: ShownMotion, count: int, size: float) -> Tracks:
    tracks = Tracks(motion.times)
    robot.animate(tracks, robot.robot.configuration(motion.values))
    linear, angular = np.swapaxes(motion.twists[:, :3], 1, 2), np.swapaxes(motion.twists[:, 3:], 1, 2)
    lost = LostDirections(linear, angular, np.ones(linear.shape[:2]))
    marks.animate_lost(tracks, groups["lost"], count, lost, motion.marked, size)
    animate_wrenches(tracks, groups["wrench"], count, Wrenches.of(motion.twists, motion.marked, size), size)
    return tracks


def _place_camera(scene: Scene, robot: DrawnRobot, motions: Sequence[ShownMotion]) -> float:
    """Places floor and camera so that the arm is always in view; returns the radius of the view, m."""
    points = [robot.extent(robot.robot.rest)]
    for motion in motions:
        which = np.linspace(0, len(motion.values) - 1, LOOKS).round().astype(int)
        points += [robot.extent(q) for q in robot.robot.configuration(motion.values[which])]
    seen = np.concatenate(points)
    low, high = seen.min(axis=0), seen.max(axis=0)
    size = float(np.linalg.norm(high - low)) / 2
    scene.look_at(seen, _most_lost(motions) if motions else None)
    scene.add_floor(size, min(0.0, float(low[2])))
    return size


def _most_lost(motions: Sequence[ShownMotion]) -> Array:
    """The horizontal direction with most lost translations: across the view, their arrows are seen best."""
    level = np.concatenate([np.swapaxes(motion.twists[:, :2], 0, 1).reshape(2, -1) for motion in motions], axis=1)
    return np.array([*svd(level @ level.T + 1e-12 * np.diag([1.0, 0.0])).U[:, 0], 0.0])
