"""Searches for single singular configurations, and steps along the set of them."""
