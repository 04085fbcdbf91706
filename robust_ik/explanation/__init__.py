"""What an inverse made of one commanded velocity, direction by direction. Arrays only."""

from robust_ik.explanation.directions import Branch, Direction
from robust_ik.explanation.step import Explanation, explain, unavoidable_angle

__all__ = ["Branch", "Direction", "Explanation", "explain", "unavoidable_angle"]
