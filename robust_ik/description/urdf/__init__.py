"""URDF and xacro files: read, repaired and checked."""

from robust_ik.description.urdf.mobile_base import stand_on
from robust_ik.description.urdf.mobile_joints import PARTS
from robust_ik.description.urdf.urdf_checks import safe_tree
from robust_ik.description.urdf.urdf_reader import fix_joints, lock_slides, parse_urdf, read_urdf
from robust_ik.description.urdf.written_digits import last_places
from robust_ik.description.urdf.xacro_files import checked_arguments

__all__ = [
    "PARTS",
    "checked_arguments",
    "fix_joints",
    "last_places",
    "lock_slides",
    "parse_urdf",
    "read_urdf",
    "safe_tree",
    "stand_on",
]
