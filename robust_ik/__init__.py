"""Singularity-robust inverse kinematics for any robot arm, on Pinocchio.

Conventions: rad, m, s. Twists are (..., 6), linear rows first. The default reference of Jacobians is
LOCAL_WORLD_ALIGNED: the tool's point, the world's axes. Arrays take leading batch axes everywhere.
"""

from importlib.metadata import version as _version

from robust_ik import certificates, evaluation, inverses, stability
from robust_ik.comparing import compare
from robust_ik.controller import VelocityController
from robust_ik.derivatives import manipulability_gradient, singular_value_gradient, singular_value_gradients
from robust_ik.description import Box, Cylinder, Sphere
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
    GainFormula,
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
from robust_ik.limits import CollisionLimit, HalfSpace, IgnoredPair, JointLimits, Limit, Obstacle, PairDistance
from robust_ik.linalg import condition_number, lost_directions, manipulability, null_projector, svd
from robust_ik.loading import load
from robust_ik.measures import measure_bounds
from robust_ik.newton import NewtonResult, NewtonStatus, newton
from robust_ik.paths import Circle, Keypoints, Line, OutAndBack, Sinusoid, Turning
from robust_ik.resolution import LevelResult, Resolution, Status
from robust_ik.resolvers import (
    DecoupledPriority,
    Limiter,
    QuadraticProgram,
    Resolver,
    Saturation,
    Scaling,
    TaskPriority,
    TaskReconstruction,
    WeightedPriority,
)
from robust_ik.robot import Robot
from robust_ik.scenario import Scenario
from robust_ik.scenarios import load_scenario
from robust_ik.simulation import simulate
from robust_ik.singularities import SingularityAtlas, Stratum, find_singularities
from robust_ik.stepper import Stepper
from robust_ik.tasks import (
    DampingTask,
    DirectionTask,
    Follow,
    FrameTask,
    JointTask,
    ManipulabilityTask,
    OrientationTask,
    PositionTask,
    PostureTask,
    RelativeTask,
    Replay,
    SingularValueTask,
    Stack,
    Task,
    TwistCommand,
    TwistTask,
    pose_error,
)
from robust_ik.trajectory import Trajectory
from robust_ik.workspace import Cells, WorkspaceMap, map_workspace

__version__ = _version("robust-ik")

__all__ = [
    "EDLS",
    "ESRIM",
    "SDLS",
    "Box",
    "Cells",
    "ChanLawrence",
    "Chiaverini",
    "ChiaveriniFiltering",
    "Circle",
    "CollisionLimit",
    "Cylinder",
    "DHError",
    "DHJoint",
    "DHTable",
    "DampedLeastSquares",
    "DampingTask",
    "DecoupledPriority",
    "DirectionTask",
    "DulebaAdditive",
    "DulebaClamp",
    "Explanation",
    "FilteredInverse",
    "Follow",
    "FrameNotFoundError",
    "FrameTask",
    "GainFormula",
    "HalfSpace",
    "Halley",
    "IgnoredPair",
    "InputError",
    "JParse",
    "JParsePositionFirst",
    "JParseWithGains",
    "JointLimits",
    "JointTask",
    "KelmarKhosla",
    "Keypoints",
    "LevelResult",
    "Limit",
    "Limiter",
    "Line",
    "LoadError",
    "MaciejewskiKlein",
    "ManipulabilityTask",
    "MoorePenrose",
    "NakamuraHanafusa",
    "NewtonResult",
    "NewtonStatus",
    "Obstacle",
    "OrientationTask",
    "OutAndBack",
    "PairDistance",
    "PositionTask",
    "PostureTask",
    "QuadraticProgram",
    "RelativeTask",
    "Replay",
    "Resolution",
    "Resolver",
    "Robot",
    "RobotNotFoundError",
    "RobustIKError",
    "RobustInverse",
    "Saturation",
    "Scaling",
    "Scenario",
    "Sigmoid",
    "SingularValueFilter",
    "SingularValueTask",
    "SingularityAtlas",
    "Sinusoid",
    "Sphere",
    "Stack",
    "Status",
    "Stepper",
    "Stratum",
    "Sugihara",
    "Task",
    "TaskPriority",
    "TaskReconstruction",
    "TipError",
    "Trajectory",
    "TruncatedSVD",
    "Turning",
    "TwistCommand",
    "TwistTask",
    "UrdfError",
    "UserDefinedAccuracy",
    "VelocityController",
    "Weighted",
    "WeightedPriority",
    "WorkspaceMap",
    "__version__",
    "certificates",
    "compare",
    "condition_number",
    "evaluation",
    "explain",
    "find_singularities",
    "inverses",
    "load",
    "load_scenario",
    "lost_directions",
    "manipulability",
    "manipulability_gradient",
    "map_workspace",
    "measure_bounds",
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
