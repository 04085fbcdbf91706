"""Searches for single singular configurations, and steps along families of them."""

from robust_ik.singularities.find.gradient_history import Descent, gradient_descent
from robust_ik.singularities.find.gradient_search import FOUND, gradient_search
from robust_ik.singularities.find.projection_search import SearchEnds

__all__ = ["FOUND", "Descent", "SearchEnds", "gradient_descent", "gradient_search"]
