"""Joint motions along paths of poses: every branch at once, and what ends each of them. Arrays only."""

from robust_ik.paths.planner import PathPlanner
from robust_ik.paths.pose_path import PosePath
from robust_ik.paths.result import Hindrance, PathPiece, PathPlan, PathStatus, PathStop

__all__ = ["Hindrance", "PathPiece", "PathPlan", "PathPlanner", "PathStatus", "PathStop", "PosePath"]
