"""Simulation of whole runs: a controller along a path, scenarios and their comparison."""
