"""A scenario whose tip goes round where the straight way ends, in place of a plain servo."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from robust_ik.control.reaching import Reach
from robust_ik.control.tasks import Follow
from robust_ik.errors import InputError
from robust_ik.simulation.scenario import Scenario
from robust_ik.simulation.scenarios.stretch import Stretch

Given = TypeVar("Given", Scenario, Stretch)


def with_reach(scenario: Given) -> Given:
    """The same scenario with `Reach` in the place of the `FrameTask` that keeps its tip on the path.

    Raises:
        InputError: Its motion is no path that a tip follows.
    """
    if isinstance(scenario, Stretch):
        return replace(scenario, task=Reach)
    if not isinstance(scenario.motion, Follow):
        raise InputError(f"{scenario.name} has no path to reach: its motion is {type(scenario.motion).__name__}")
    return replace(scenario, motion=replace(scenario.motion, task=Reach))
