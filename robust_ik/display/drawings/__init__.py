"""Robots, runs and families as drawings in a scene."""
