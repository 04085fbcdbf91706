"""The screw axes of an arm, on which singular configurations depend."""

from robust_ik.singularities.geometry.screw_chain import ScrewChain

__all__ = [
    "ScrewChain",
]
