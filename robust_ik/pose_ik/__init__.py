"""Inverse kinematics of poses, positions and partial poses, within joint limits. Arrays only."""

from robust_ik.pose_ik.inputs import as_poses, is_plain_pose, is_position, wanted_rows
from robust_ik.pose_ik.options import PoseOptions
from robust_ik.pose_ik.result import PoseResult, PoseResults, PoseStatus
from robust_ik.pose_ik.solver import PoseSolver

__all__ = [
    "PoseOptions",
    "PoseResult",
    "PoseResults",
    "PoseSolver",
    "PoseStatus",
    "as_poses",
    "is_plain_pose",
    "is_position",
    "wanted_rows",
]
