"""Tasks: each gives an equation J q̇ = ẋ for a robot at q. A stack of them is a list of levels, each a list of tasks."""

from robust_ik.tasks.base import Task
from robust_ik.tasks.climbing import ClimbingTask
from robust_ik.tasks.damping import DampingTask
from robust_ik.tasks.direction import DirectionTask
from robust_ik.tasks.follow import Follow
from robust_ik.tasks.frame import FrameTask
from robust_ik.tasks.joint import JointTask
from robust_ik.tasks.joint_range import JointRangeTask
from robust_ik.tasks.manipulability import ManipulabilityTask
from robust_ik.tasks.orientation import OrientationTask
from robust_ik.tasks.pose_error import pose_error
from robust_ik.tasks.position import PositionTask
from robust_ik.tasks.posture import PostureTask
from robust_ik.tasks.relative import RelativeTask
from robust_ik.tasks.replay import Replay
from robust_ik.tasks.singular_value import SingularValueTask
from robust_ik.tasks.stack import Stack, checked_levels, checked_stack
from robust_ik.tasks.teleoperation import TwistCommand
from robust_ik.tasks.twist import TwistTask

__all__ = [
    "ClimbingTask",
    "DampingTask",
    "DirectionTask",
    "Follow",
    "FrameTask",
    "JointRangeTask",
    "JointTask",
    "ManipulabilityTask",
    "OrientationTask",
    "PositionTask",
    "PostureTask",
    "RelativeTask",
    "Replay",
    "SingularValueTask",
    "Stack",
    "Task",
    "TwistCommand",
    "TwistTask",
    "checked_levels",
    "checked_stack",
    "pose_error",
]
