"""Drawings of robots, runs and families in a scene."""
