"""Singularity-robust inverse kinematics for any robot arm, on Pinocchio.

Conventions: rad, m, s. Twists are (..., 6), linear rows first. The default reference of Jacobians is
LOCAL_WORLD_ALIGNED: the tool's point, the world's axes. Arrays take leading batch axes everywhere.
"""

from importlib.metadata import version as _version

from robust_ik import evaluation, inverses, stability
from robust_ik.controller import Posture, VelocityController
from robust_ik.derivatives import manipulability_gradient, singular_value_gradient, singular_value_gradients
from robust_ik.dh import DHJoint, DHTable
from robust_ik.dh_toml import read_dh
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
from robust_ik.explanation import Explanation, explain, unavoidable_angle
from robust_ik.inverses import (
    EDLS,
    ESRIM,
    SDLS,
    ChanLawrence,
    Chiaverini,
    ChiaveriniFiltering,
    DampedLeastSquares,
    DulebaAdditive,
    DulebaClamp,
    FilteredInverse,
    Halley,
    JParse,
    JParsePositionFirst,
    JParseWithGains,
    KelmarKhosla,
    MaciejewskiKlein,
    MoorePenrose,
    NakamuraHanafusa,
    RobustInverse,
    Sigmoid,
    SingularValueFilter,
    Sugihara,
    TruncatedSVD,
    UserDefinedAccuracy,
    Weighted,
)
from robust_ik.linalg import condition_number, lost_directions, manipulability, null_projector, svd
from robust_ik.loading import load
from robust_ik.newton import NewtonResult, NewtonStatus, newton
from robust_ik.paths import Keypoints, OutAndBack
from robust_ik.robot import Robot
from robust_ik.simulation import Trajectory, simulate
from robust_ik.tasks import FrameTask, pose_error

__version__ = _version("robust-ik")

__all__ = [
    "EDLS",
    "ESRIM",
    "SDLS",
    "ChanLawrence",
    "Chiaverini",
    "ChiaveriniFiltering",
    "DHError",
    "DHJoint",
    "DHTable",
    "DampedLeastSquares",
    "DulebaAdditive",
    "DulebaClamp",
    "Explanation",
    "FilteredInverse",
    "FrameNotFoundError",
    "FrameTask",
    "Halley",
    "InputError",
    "JParse",
    "JParsePositionFirst",
    "JParseWithGains",
    "KelmarKhosla",
    "Keypoints",
    "LoadError",
    "MaciejewskiKlein",
    "MoorePenrose",
    "NakamuraHanafusa",
    "NewtonResult",
    "NewtonStatus",
    "OutAndBack",
    "Posture",
    "Robot",
    "RobotNotFoundError",
    "RobustIKError",
    "RobustInverse",
    "Sigmoid",
    "SingularValueFilter",
    "Sugihara",
    "TipError",
    "Trajectory",
    "TruncatedSVD",
    "UrdfError",
    "UserDefinedAccuracy",
    "VelocityController",
    "Weighted",
    "__version__",
    "condition_number",
    "evaluation",
    "explain",
    "inverses",
    "load",
    "lost_directions",
    "manipulability",
    "manipulability_gradient",
    "newton",
    "null_projector",
    "pose_error",
    "read_dh",
    "simulate",
    "singular_value_gradient",
    "singular_value_gradients",
    "stability",
    "svd",
    "unavoidable_angle",
]
