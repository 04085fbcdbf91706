"""Motions to run: each says the robot, where it starts, the path and the gains."""

from robust_ik.scenarios.kim import KimCircle, kim_circle
from robust_ik.scenarios.straight_line import StraightLine, ur5_elbow, ur5_wrist
from robust_ik.scenarios.stretch import Scenario, stretch

__all__ = ["KimCircle", "Scenario", "StraightLine", "kim_circle", "stretch", "ur5_elbow", "ur5_wrist"]
