"""Finds a proof by exact kinematics, minors, factors and cases."""

from robust_ik.certificates.prover.exact_arm import UnsupportedError, exact_arm

__all__ = [
    "UnsupportedError",
    "exact_arm",
]
