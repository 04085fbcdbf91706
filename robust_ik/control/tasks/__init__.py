"""Tasks: each gives an equation J q̇ = ẋ for a robot at q. A stack is a list of levels, each a list of tasks."""

from robust_ik.control.tasks.base import Task
from robust_ik.control.tasks.damping import DampingTask
from robust_ik.control.tasks.direction import DirectionTask
from robust_ik.control.tasks.follow import Follow
from robust_ik.control.tasks.frame import FrameTask
from robust_ik.control.tasks.joint import JointTask
from robust_ik.control.tasks.joint_range import JointRangeTask
from robust_ik.control.tasks.manipulability import ManipulabilityTask
from robust_ik.control.tasks.measure_climbing import ClimbingTask
from robust_ik.control.tasks.orientation import OrientationTask
from robust_ik.control.tasks.pose_difference import pose_error
from robust_ik.control.tasks.position import PositionTask
from robust_ik.control.tasks.posture import PostureTask
from robust_ik.control.tasks.relative import RelativeTask
from robust_ik.control.tasks.replay import Replay
from robust_ik.control.tasks.singular_value import SingularValueTask
from robust_ik.control.tasks.stack import Levels, Stack, checked_levels, checked_stack
from robust_ik.control.tasks.target_paths import Circle, Keypoints, Line, OutAndBack, Sinusoid, Turning, pose
from robust_ik.control.tasks.teleoperation import TwistCommand
from robust_ik.control.tasks.twist import TwistTask

__all__ = [
    "Circle",
    "ClimbingTask",
    "DampingTask",
    "DirectionTask",
    "Follow",
    "FrameTask",
    "JointRangeTask",
    "JointTask",
    "Keypoints",
    "Levels",
    "Line",
    "ManipulabilityTask",
    "OrientationTask",
    "OutAndBack",
    "PositionTask",
    "PostureTask",
    "RelativeTask",
    "Replay",
    "SingularValueTask",
    "Sinusoid",
    "Stack",
    "Task",
    "Turning",
    "TwistCommand",
    "TwistTask",
    "checked_levels",
    "checked_stack",
    "pose",
    "pose_error",
]
