"""Tasks: each gives an equation J q̇ = ẋ for a robot at q."""

from robust_ik.tasks.frame import FrameTask, pose_error

__all__ = ["FrameTask", "pose_error"]
