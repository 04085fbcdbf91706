"""Explains what an inverse made of one commanded velocity, direction by direction. Arrays only."""

from robust_ik.analysis.explanation.explanation import Explanation, direction_in_words, explain, unavoidable_angle
from robust_ik.analysis.explanation.singular_directions import Branch, Direction

__all__ = ["Branch", "Direction", "Explanation", "direction_in_words", "explain", "unavoidable_angle"]
