"""Motions to run: each says the robot, where it starts, the path and the gains."""

from robust_ik.scenarios.stretch import Scenario, stretch

__all__ = ["Scenario", "stretch"]
