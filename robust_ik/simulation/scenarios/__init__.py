"""Scenarios: motions to run, with robot, start, path and gains."""

from robust_ik.simulation.scenarios.catalogue import load_scenario, scenarios
from robust_ik.simulation.scenarios.claim_verdict import verdict
from robust_ik.simulation.scenarios.going_round import with_reach
from robust_ik.simulation.scenarios.method_tables import RESOLVERS
from robust_ik.simulation.scenarios.point_by_point import reach_points
from robust_ik.simulation.scenarios.scenario_toml import read_scenario
from robust_ik.simulation.scenarios.straight_line import StraightLine, ur5_elbow, ur5_wrist
from robust_ik.simulation.scenarios.stretch import Stretch, stretch

__all__ = [
    "RESOLVERS",
    "StraightLine",
    "Stretch",
    "load_scenario",
    "reach_points",
    "read_scenario",
    "scenarios",
    "stretch",
    "ur5_elbow",
    "ur5_wrist",
    "verdict",
    "with_reach",
]
