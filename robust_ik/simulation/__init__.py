"""Whole runs: a controller driven along a path, scenarios and their comparison."""
