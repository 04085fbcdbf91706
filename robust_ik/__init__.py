"""Singularity-robust inverse kinematics for any robot arm, on Pinocchio.

Conventions: rad, m, s. Twists are (..., 6), linear rows first. The default reference of Jacobians is
LOCAL_WORLD_ALIGNED: the tool's point, the world's axes. Arrays take leading batch axes everywhere.
"""

from importlib.metadata import version as _version

from robust_ik.controller import Posture, VelocityController
from robust_ik.derivatives import manipulability_gradient, singular_value_gradient, singular_value_gradients
from robust_ik.dh import DHJoint, DHTable
from robust_ik.dh_toml import read_dh
from robust_ik.dh_urdf import dh_to_urdf
from robust_ik.errors import (
    DHError,
    FrameNotFoundError,
    InputError,
    LoadError,
    RobotNotFoundError,
    RobustIKError,
    TipError,
    UrdfError,
)
from robust_ik.inverses import DampedLeastSquares, JParse, MoorePenrose, RobustInverse, SingularValueFilter
from robust_ik.linalg import condition_number, lost_directions, manipulability, null_projector, svd
from robust_ik.loading import load
from robust_ik.paths import Keypoints, OutAndBack
from robust_ik.robot import Robot
from robust_ik.simulation import Trajectory, simulate
from robust_ik.tasks import FrameTask, pose_error

__version__ = _version("robust-ik")

__all__ = [
    "DHError",
    "DHJoint",
    "DHTable",
    "DampedLeastSquares",
    "FrameNotFoundError",
    "FrameTask",
    "InputError",
    "JParse",
    "Keypoints",
    "LoadError",
    "MoorePenrose",
    "OutAndBack",
    "Posture",
    "Robot",
    "RobotNotFoundError",
    "RobustIKError",
    "RobustInverse",
    "SingularValueFilter",
    "TipError",
    "Trajectory",
    "UrdfError",
    "VelocityController",
    "__version__",
    "condition_number",
    "dh_to_urdf",
    "load",
    "lost_directions",
    "manipulability",
    "manipulability_gradient",
    "null_projector",
    "pose_error",
    "read_dh",
    "simulate",
    "singular_value_gradient",
    "singular_value_gradients",
    "svd",
]
