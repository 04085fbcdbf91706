"""A proof as data: its cases, its leaves, and how they are read."""

from robust_ik.certificates.proof.float_jacobian import float_jacobian
from robust_ik.certificates.proof.leaf_points import members
from robust_ik.certificates.proof.proof_arm import Arm
from robust_ik.certificates.proof.untrusted_json import read_json

__all__ = [
    "Arm",
    "float_jacobian",
    "members",
    "read_json",
]
