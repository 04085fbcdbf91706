"""Searches for single singular configurations, and steps along families of them."""

from robust_ik.singularities.find.gradient_history import Descent
from robust_ik.singularities.find.gradient_search import FOUND

__all__ = ["FOUND", "Descent"]
