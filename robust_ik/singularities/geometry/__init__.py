"""The screw axes of an arm, and what singular configurations depend on."""

from robust_ik.singularities.geometry.screw_chain import ScrewChain

__all__ = [
    "ScrewChain",
]
