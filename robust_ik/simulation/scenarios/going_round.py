"""A scenario with `Reach` instead of a plain servo, so that its tip goes round where the straight way ends."""

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
    """The same scenario with `Reach` instead of the `FrameTask` that keeps its tip on the path.

    Raises:
        InputError: Its motion is not a path that a tip follows.
    """
    if isinstance(scenario, Stretch):
        return replace(scenario, task=Reach)
    if not isinstance(scenario.motion, Follow):
        raise InputError(f"{scenario.name} has no path to reach: its motion is {type(scenario.motion).__name__}")
    return replace(scenario, motion=replace(scenario.motion, task=Reach))
