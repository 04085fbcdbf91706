"""Places the camera for a run: arm and path always in view, arrows seen from the side."""

from __future__ import annotations

import numpy as np

from robust_ik.checks import Array
from robust_ik.display.drawings.drawn_robot import DrawnRobot
from robust_ik.display.drawings.marks import LostDirections
from robust_ik.display.drawings.run_frames import Frames
from robust_ik.display.scene.scene import Scene
from robust_ik.kinematics.svd import svd


def place_camera(scene: Scene, robot: DrawnRobot, frames: Frames, lost: LostDirections) -> float:
    """Places floor and camera so that arm and path are in view; returns the radius of the view, m.

    If a run diverges, the tip may be anywhere: points far outside are ignored.
    """
    points = _near(_points(robot, frames), robot.extent(frames.q[0]))
    away = _outwards(frames)
    scene.look_at(points, _most_seen(away, lost), away)
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(np.linalg.norm(high - low)) / 2
    scene.add_floor(size, min(0.0, float(low[2])))
    return size


def _points(robot: DrawnRobot, frames: Frames) -> Array:
    """Corners of the drawn robot at some times, and the whole paths of target and tip, (N, 3)."""
    samples = np.linspace(0, len(frames.rows) - 1, 12).round().astype(int)
    arm = np.concatenate([robot.extent(q) for q in frames.q[samples]])
    return np.concatenate([arm, frames.target[:, :3, 3], frames.tip])


def _near(points: Array, extent: Array) -> Array:
    """The points that are within a few times the robot's size."""
    far = 8 * float(np.linalg.norm(extent[1] - extent[0])) + 1e-3
    distance = np.abs(points - extent.mean(axis=0)).max(axis=1)
    return np.concatenate([extent, points[distance < far]])


def _outwards(frames: Frames) -> Array:
    """The horizontal part of the unit vector from the first joint to the farthest position of the target."""
    robot = frames.run.robot
    name = robot.description.moving_joints(robot.tip or robot.description.root)[0]
    shoulder = robot.pose(frames.q[0], robot.description.joint[name].child)[:3, 3]
    away = frames.target[:, :3, 3] - shoulder
    farthest = away[np.argmax(np.linalg.norm(away, axis=1))]
    return np.asarray(farthest * [1.0, 1.0, 0.0] / max(float(np.linalg.norm(farthest)), np.finfo(float).tiny))


def _most_seen(away: Array, lost: LostDirections) -> Array:
    """A horizontal direction to lie across the view: where arrows point, and where the arm reaches."""
    main = svd(2 * lost.spread[:2, :2] + np.outer(away[:2], away[:2])).U[:, 0]
    return np.array([*(main if main @ away[:2] >= 0 else -main), 0.0])
