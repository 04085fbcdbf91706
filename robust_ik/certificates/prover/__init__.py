"""Finds a proof by exact kinematics, minors, factors and cases."""

from robust_ik.certificates.prover.exact_arm import UnsupportedError, arm_of_moves, exact_arm

__all__ = [
    "UnsupportedError",
    "arm_of_moves",
    "exact_arm",
]
