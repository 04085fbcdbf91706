"""Draws recorded runs: the robot and its marks once, an animation for each run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from robust_ik.checks.public_arguments import checked
from robust_ik.display.drawings import marks
from robust_ik.display.drawings.drawn_robot import DrawnRobot, draw_robot
from robust_ik.display.drawings.marks import GAMMA, Ellipsoids, LostDirections
from robust_ik.display.drawings.run_camera import place_camera
from robust_ik.display.drawings.run_frames import Frames
from robust_ik.display.scene.animation_tracks import Tracks
from robust_ik.display.scene.meshcat_module import Visualizer
from robust_ik.display.scene.primitives import Color
from robust_ik.display.scene.scene import Scene
from robust_ik.errors import InputError
from robust_ik.simulation.trajectory import Trajectory

PATH_COLOR: Color = (0.45, 0.50, 0.55, 1.0)
TRAIL_COLOR: Color = (0.12, 0.47, 0.78, 1.0)


@dataclass(frozen=True, eq=False)
class DrawnRuns:
    """Runs in a scene.

    Attributes:
        robot: The robot.
        animations: One for each run.
        trails: The node of each run's trail; all but the first are hidden.
        groups: Nodes of the marks that can be hidden, by kind: lost, ellipsoid, target, trail.
        ellipsoid_scale: Metres drawn for a singular value of 1, 0 without an ellipsoid.
    """

    robot: DrawnRobot
    animations: tuple[Tracks, ...]
    trails: tuple[Visualizer, ...]
    groups: dict[str, Visualizer]
    ellipsoid_scale: float


@checked
def draw_run(scene: Scene, run: Trajectory, *, gamma: float = GAMMA) -> DrawnRobot:
    """Draws a run and plays it repeatedly; earlier drawings are removed.

    Args:
        scene: The scene.
        run: The run.
        gamma: A direction counts as being lost below this fraction of the largest singular value.
    """
    drawn = draw_runs(scene, [run], [TRAIL_COLOR], gamma)
    scene.visualizer.window.send(drawn.animations[0].command())
    return drawn.robot


def draw_runs(scene: Scene, runs: Sequence[Trajectory], colors: Sequence[Color], gamma: float = GAMMA) -> DrawnRuns:
    """Draws runs of one robot, without starting an animation.

    Args:
        scene: The scene; earlier drawings are removed.
        runs: The runs, at least one.
        colors: A colour for each run's trail.
        gamma: As for `draw_run`.

    Raises:
        InputError: There is no run, or they are of different robots.
    """
    _check_alike(runs)
    shown = [Frames.of(run) for run in runs]
    scene.clear()
    robot = draw_robot(scene["robot"], runs[0].robot, runs[0].q[0])
    lost = [LostDirections.of(frames.jacobians, frames.run.robot.rows, gamma) for frames in shown]
    size = place_camera(scene, robot, shown[0], lost[0])
    groups = {kind: scene[kind] for kind in ("lost", "ellipsoid", "target", "trail")}
    animations = tuple(Tracks(frames.times) for frames in shown)
    for frames, tracks in zip(shown, animations):
        robot.animate(tracks, frames.q)
    _draw_lost(groups["lost"], shown, animations, lost, 0.28 * size)
    scale = _draw_ellipsoid(groups["ellipsoid"], shown, animations, 0.3 * size)
    _draw_target(groups["target"], shown, animations, size)
    trails = tuple(_draw_trails(groups["trail"], shown, colors, 0.006 * size))
    return DrawnRuns(robot, animations, trails, groups, scale)


def _check_alike(runs: Sequence[Trajectory]) -> None:
    if not runs:
        raise InputError("there is no run to draw: give at least one Trajectory")
    for run in runs[1:]:
        first, other = runs[0].robot, run.robot
        if (first.description.xml, first.tip, first.nq) != (other.description.xml, other.tip, other.nq):
            raise InputError(f"the runs must be of one robot, got {first!r} and {other!r}")


def _draw_lost(
    node: Visualizer,
    shown: Sequence[Frames],
    animations: Sequence[Tracks],
    lost: Sequence[LostDirections],
    size: float,
) -> None:
    count = max(directions.count for directions in lost)
    marks.draw_lost(node, count)
    for frames, tracks, directions in zip(shown, animations, lost):
        marks.animate_lost(tracks, node, count, directions, frames.tip, size)


def _draw_ellipsoid(node: Visualizer, shown: Sequence[Frames], animations: Sequence[Tracks], size: float) -> float:
    """Draws the ellipsoid so that its longest semi-axis in the first run is `size`; returns the scale."""
    ellipsoids = [Ellipsoids.of(frames.jacobians, frames.run.robot.rows) for frames in shown]
    if ellipsoids[0] is None:
        return 0.0
    longest = float(ellipsoids[0].lengths.max())
    scale = size / longest if longest > 0 else 1.0
    marks.draw_ellipsoid(node)
    for frames, tracks, shape in zip(shown, animations, ellipsoids):
        if shape is not None:
            marks.animate_ellipsoid(tracks, node, shape, frames.tip, scale, 0.015 * size)
    return scale


def _draw_target(node: Visualizer, shown: Sequence[Frames], animations: Sequence[Tracks], size: float) -> None:
    marks.draw_target(node["pose"], 0.11 * size)
    path = marks.corners_of_path(shown[0].target[:, :3, 3])
    marks.draw_path(node["path"], path, 0.0035 * size, PATH_COLOR)
    for frames, tracks in zip(shown, animations):
        tracks.pose(node["pose"], frames.target)


def _draw_trails(node: Visualizer, shown: Sequence[Frames], colors: Sequence[Color], radius: float) -> list[Visualizer]:
    trails = [node[f"trail{index}"] for index in range(len(shown))]
    for index, (trail, frames, color) in enumerate(zip(trails, shown, colors)):
        marks.draw_path(trail, frames.tip, radius, color)
        trail.set_property("visible", index == 0)
    return trails
