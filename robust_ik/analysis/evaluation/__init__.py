"""Dułęba's evaluation of singularity-robust inverses: changes of the Jacobian, and safety. Arrays only."""

from robust_ik.analysis.evaluation.determinants import (
    allows_multiplicative_inverse,
    determinant_excess,
    fatal_dampings,
)
from robust_ik.analysis.evaluation.matched_damping import DulebaMatched
from robust_ik.analysis.evaluation.modification import (
    Comparison,
    compare_damping_and_clamp,
    matching_squared_damping,
    modification_by_clamp,
    modification_by_damping,
    safety_by_clamp,
    safety_by_damping,
)
from robust_ik.analysis.evaluation.normalisation import normalise

__all__ = [
    "Comparison",
    "DulebaMatched",
    "allows_multiplicative_inverse",
    "compare_damping_and_clamp",
    "determinant_excess",
    "fatal_dampings",
    "matching_squared_damping",
    "modification_by_clamp",
    "modification_by_damping",
    "normalise",
    "safety_by_clamp",
    "safety_by_damping",
]
